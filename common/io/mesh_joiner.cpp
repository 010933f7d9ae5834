#include "common/io/mesh_joiner.h"

#include <cstring>
#include <limits>

#include "common/error.h"

namespace lode {

MeshJoiner::MeshJoiner(AttributeSet attributes, uint64_t triangles) {
  whole_.attributes = attributes;
  whole_.triangles.reserve(triangles);
}

void MeshJoiner::add(const Mesh& part) {
  const bool has_attributes = !part.vertex_attributes.empty();
  renumbered_.resize(part.positions.size());
  for (size_t i = 0; i < part.positions.size(); ++i) {
    const Wedge wedge{part.positions[i], has_attributes ? part.vertex_attributes[i] : VertexAttributes{}};
    const auto [entry, is_new] = numbers_.try_emplace(wedge, static_cast<uint32_t>(whole_.positions.size()));
    renumbered_[i] = entry->second;
    if (!is_new) continue;
    if (whole_.positions.size() == std::numeric_limits<uint32_t>::max()) {
      throw Error(ErrorCode::kLimit, "the cut has more than 4294967295 vertices; ask for a coarser cut");
    }
    whole_.positions.push_back(wedge.position);
    if (has_attributes) whole_.vertex_attributes.push_back(wedge.attributes);
  }
  for (const glm::u32vec3& t : part.triangles) {
    whole_.triangles.emplace_back(renumbered_[t.x], renumbered_[t.y], renumbered_[t.z]);
  }
}

/// Hashes a wedge with the mixing steps of SplitMix64 (Steele et al., Fast Splittable Pseudorandom Number
/// Generators, 2014).
size_t MeshJoiner::WedgeHash::operator()(const Wedge& wedge) const noexcept {
  uint64_t low;
  uint32_t high;
  static_assert(sizeof wedge.attributes == sizeof low + sizeof high);
  std::memcpy(&low, &wedge.attributes, sizeof low);
  std::memcpy(&high, reinterpret_cast<const std::byte*>(&wedge.attributes) + sizeof low, sizeof high);
  uint64_t hash = wedge.position.value * 0x9e3779b97f4a7c15u;
  hash = (hash ^ hash >> 32 ^ low) * 0xbf58476d1ce4e5b9u;
  hash = (hash ^ hash >> 29 ^ high) * 0x94d049bb133111ebu;
  return hash ^ hash >> 32;
}

}  // namespace lode
