#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/mesh/soup_triangle.h"

namespace lode::ingest {

/// A leaf's soup as a mesh, nothing locked yet. @param records  storeSoup's bytes, one triangle after the
/// other.
NodeMesh weldSoup(std::span<const std::byte> records, AttributeSet attributes, MeshWelder& welder);

/// Notes a leaf's mesh, of which nothing is locked yet.
void putLeaf(RecordWriter& record, const NodeMesh& mesh);
/// @throws Error kFormat where the record is of another length or a triangle has no three corners.
NodeMesh getLeaf(RecordReader& record, AttributeSet attributes);

/// Sum of the triangles' cross products at each position, in lattice steps: integers, so that sums over
/// leaves do not depend on their order. Twice the area weighs each triangle's normal.
std::vector<glm::i64vec3> sumNormals(const NodeMesh& mesh);
}  // namespace lode::ingest
