#pragma once

#include "server/ingest/simplify/collapse_mesh.h"

namespace lode::ingest {

/// Gives each position the quadric of what meets there: the planes of its triangles by their area, a little
/// of its own place, and planes upright on rims and seams, so that these keep their course.
void addQuadrics(CollapseMesh& mesh);

}  // namespace lode::ingest
