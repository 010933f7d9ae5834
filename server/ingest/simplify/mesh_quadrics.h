#pragma once

#include "server/ingest/simplify/collapse_mesh.h"

namespace lode::ingest {

/// Gives each position the quadric of what meets there: the planes of its triangles by their area, and a
/// little of its own place.
void addPlanes(CollapseMesh& mesh);
/// Adds to the ends of a boundary or a seam a plane upright on it, so that it keeps its course; to those of
/// another edge nothing.
void addFeature(CollapseMesh& mesh, const CollapseMesh::Edge& edge);

}  // namespace lode::ingest
