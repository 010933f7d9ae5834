#include "client/render/residency/gpu_vertex.h"

#include <cmath>
#include <cstring>
#include <vector>

#include "common/codec/octahedral.h"

namespace lode::render {
namespace {

uint32_t packNormal(glm::vec3 normal) {
  const auto component = [](float value) {
    return static_cast<uint32_t>(static_cast<int32_t>(std::lround(value * 511.0f))) & 0x3ff;
  };
  return component(normal.x) | component(normal.y) << 10 | component(normal.z) << 20;
}

const std::vector<uint32_t>& normalTable() {
  static const std::vector<uint32_t> table = [] {
    std::vector<uint32_t> packed(1u << 16);
    for (uint32_t code = 0; code < packed.size(); ++code) {
      packed[code] = packNormal(decodeOctahedral(static_cast<uint16_t>(code)));
    }
    return packed;
  }();
  return table;
}

}  // namespace

void packVertices(const Mesh& mesh, size_t first, std::span<std::byte> out) {
  const std::vector<uint32_t>& normals = normalTable();
  const bool has_attributes = !mesh.vertex_attributes.empty();
  const uint32_t bytes = vertexBytes(mesh.attributes);
  for (size_t i = 0; (i + 1) * bytes <= out.size(); ++i) {
    const uint64_t code = mesh.positions[first + i].value;
    const VertexAttributes attributes =
        has_attributes ? mesh.vertex_attributes[first + i] : VertexAttributes{};
    const GpuTexturedVertex vertex{{static_cast<uint32_t>(code), static_cast<uint32_t>(code >> 32),
                                    normals[attributes.normal], attributes.colour},
                                   attributes.texture,
                                   attributes.material,
                                   0};
    // GpuTexturedVertex begins with the fields of GpuVertex.
    std::memcpy(out.data() + i * bytes, &vertex, bytes);
  }
}

}  // namespace lode::render
