#include "client/app/cli/cut_mesh.h"

#include <array>
#include <cstring>
#include <limits>
#include <string_view>
#include <unordered_map>

#include "common/error.h"

namespace lode::app {
namespace {

struct Wedge {
  PositionCode position;
  VertexAttributes attributes;
  bool operator==(const Wedge&) const = default;
};

struct WedgeHash {
  size_t operator()(const Wedge& wedge) const noexcept {
    std::array<char, sizeof(uint64_t) + sizeof(VertexAttributes)> bytes{};
    std::memcpy(bytes.data(), &wedge.position.value, sizeof(uint64_t));
    std::memcpy(bytes.data() + sizeof(uint64_t), &wedge.attributes, sizeof(VertexAttributes));
    return std::hash<std::string_view>()({bytes.data(), bytes.size()});
  }
};

}  // namespace

Mesh weldCut(const core::Cut& cut, AttributeSet attributes) {
  Mesh whole;
  whole.attributes = attributes;
  whole.triangles.reserve(cut.triangles);
  std::unordered_map<Wedge, uint32_t, WedgeHash> index_of;
  for (const core::CutPart& part : cut.parts) {
    const Mesh& mesh = *part.mesh;
    const bool has_attributes = !mesh.vertex_attributes.empty();
    std::vector<uint32_t> renumbered(mesh.positions.size());
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
      const Wedge wedge{mesh.positions[i], has_attributes ? mesh.vertex_attributes[i] : VertexAttributes{}};
      const auto [found, is_new] = index_of.try_emplace(wedge, static_cast<uint32_t>(whole.positions.size()));
      renumbered[i] = found->second;
      if (!is_new) continue;
      if (whole.positions.size() == std::numeric_limits<uint32_t>::max())
        throw Error(ErrorCode::kLimit,
                    "the cut has more than 4294967295 vertices: allow a larger error (--pixels)");
      whole.positions.push_back(wedge.position);
      if (has_attributes) whole.vertex_attributes.push_back(wedge.attributes);
    }
    for (const glm::u32vec3& triangle : mesh.triangles)
      whole.triangles.emplace_back(renumbered[triangle.x], renumbered[triangle.y], renumbered[triangle.z]);
  }
  return whole;
}

}  // namespace lode::app
