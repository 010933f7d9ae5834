#include "server/store/export.h"

#include <cstring>
#include <limits>
#include <string>
#include <unordered_map>

#include "common/draco_codec.h"
#include "common/error.h"

namespace lode::store {
namespace {

struct Wedge {
  PositionCode position;
  VertexAttributes attributes;
  bool operator==(const Wedge&) const = default;
};

struct WedgeHash {
  size_t operator()(const Wedge& wedge) const noexcept {
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
};

}  // namespace

Mesh readRung(const Reader& reader, const Node& node, uint32_t rung_number) {
  const Rung& rung = node.rungs[rung_number];
  Mesh mesh;
  mesh.attributes = reader.summary().attributes;
  if (!rung.payload) return mesh;
  const std::vector<std::byte> bytes = reader.readBlob(rung.payload.number);
  const PayloadExpectation expected{.triangles = rung.triangles,
                                    .vertices = rung.vertices,
                                    .attributes = reader.summary().attributes,
                                    .box = node.box};
  try {
    return decodePayload(bytes, reader.summary().lattice.step, expected);
  } catch (const Error& error) {
    throw Error(error.code(), reader.path().string() + ": node " + describeKey(node.key) + ", rung " +
                                  std::to_string(rung_number) + ": " + error.what());
  }
}

Mesh assembleCut(const Reader& reader, const Cut& cut) {
  Mesh whole;
  whole.attributes = reader.summary().attributes;
  whole.triangles.reserve(cut.triangles);
  std::unordered_map<Wedge, uint32_t, WedgeHash> numbers;
  std::vector<uint32_t> renumbered;
  for (const CutItem item : cut.items) {
    const Mesh part = readRung(reader, reader.nodes()[item.node], item.rung);
    renumbered.clear();
    for (size_t i = 0; i < part.positions.size(); ++i) {
      Wedge wedge{part.positions[i], {}};
      if (!part.vertex_attributes.empty()) wedge.attributes = part.vertex_attributes[i];
      const auto [entry, is_new] = numbers.try_emplace(wedge, static_cast<uint32_t>(whole.positions.size()));
      renumbered.push_back(entry->second);
      if (!is_new) continue;
      if (whole.positions.size() == std::numeric_limits<uint32_t>::max())
        throw Error(ErrorCode::kLimit, reader.path().string() +
                                           ": the cut has more vertices than one file can number; ask for a "
                                           "coarser one");
      whole.positions.push_back(wedge.position);
      if (!part.vertex_attributes.empty()) whole.vertex_attributes.push_back(wedge.attributes);
    }
    for (const glm::u32vec3& t : part.triangles)
      whole.triangles.push_back({renumbered[t.x], renumbered[t.y], renumbered[t.z]});
  }
  return whole;
}

}  // namespace lode::store
