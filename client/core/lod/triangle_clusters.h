#pragma once

#include "common/mesh.h"

namespace lode::core {

/// Puts triangles that lie near one another together and notes where they are, so that a renderer can leave
/// out those that are not in the picture. The order is a function of the mesh alone. Thread safe.
void clusterTriangles(Mesh& mesh);

}  // namespace lode::core
