#pragma once

#include "common/mesh.h"

namespace lode::core {

/// Sorts the triangles of a mesh into spatial clusters and computes the clusters' boxes, so that a renderer
/// can cull clusters outside the picture. Deterministic. Thread safe.
void clusterTriangles(Mesh& mesh);

}  // namespace lode::core
