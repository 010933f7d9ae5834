#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/mesh/soup_triangle.h"

namespace lode::ingest {

/// Welds a leaf's triangles to a mesh, without locks. @param records  triangles as storeSoup() wrote them.
NodeMesh weldSoup(std::span<const std::byte> records, AttributeSet attributes, MeshWelder& welder);

/// Writes a leaf's mesh, which must have no locks.
void putLeaf(RecordWriter& record, const NodeMesh& mesh);
/// @throws Error kFormat if the record's length or an index is wrong, or a triangle is degenerate.
NodeMesh getLeaf(RecordReader& record, AttributeSet attributes);

/// Sums the cross products of the triangles at each position, in lattice steps: normals weighted by twice the
/// area. Integers, so that sums over leaves do not depend on their order.
std::vector<glm::i64vec3> sumNormals(const NodeMesh& mesh);

}  // namespace lode::ingest
