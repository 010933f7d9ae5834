#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/mesh/soup_triangle.h"

namespace lode::ingest {

/// Welds a leaf's triangles into a mesh without locked vertices. @param records  triangles as storeSoup()
/// wrote them.
NodeMesh weldSoup(std::span<const std::byte> records, AttributeSet attributes, MeshWelder& welder);

/// Writes a leaf's mesh, which must have no locked vertices.
void putLeaf(RecordWriter& record, const NodeMesh& mesh);
/// Reads a mesh that putLeaf() wrote. @throws Error kFormat if the record's length or an index is wrong, or
/// if a triangle is degenerate.
NodeMesh getLeaf(RecordReader& record, AttributeSet attributes);

/// Sums the cross products of the triangles at each position, in lattice steps. The sum has the direction of
/// a vertex normal in which triangles are weighted by area. The sums are integers, so that a total over
/// several leaves does not depend on the order of the leaves.
std::vector<glm::i64vec3> sumNormals(const NodeMesh& mesh);

}  // namespace lode::ingest
