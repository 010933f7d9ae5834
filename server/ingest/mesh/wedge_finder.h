#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/mesh.h"
#include "server/ingest/mesh/number_table.h"

namespace lode::ingest {

/// Finds the wedge of a position that has given attributes, in a time that does not depend on how many wedges
/// the position has. The newest wedges of a position form a list; a hash table contains the older ones.
class WedgeFinder {
 public:
  static constexpr uint32_t kNone = UINT32_MAX;

  /// Forgets all wedges.
  void reset(size_t positions) {
    newest_.assign(positions, kNone);
    if (!older_.empty()) older_.clear();
  }
  void addPosition() { newest_.push_back(kNone); }

  /// Returns the position's wedge with these attributes, or kNone. @param attributes_of  the attributes of
  /// each wedge.
  uint32_t find(uint32_t position, const VertexAttributes& attributes,
                std::span<const VertexAttributes> attributes_of) const {
    uint32_t wedge = newest_[position];
    for (size_t i = 0; i < kListed && wedge != kNone; ++i, wedge = before_[wedge])
      if (attributes_of[wedge] == attributes) return wedge;
    if (wedge == kNone) return kNone;
    const auto found = older_.find({position, attributes});
    return found == older_.end() ? kNone : found->second;
  }
  /// Returns some wedge of the position, or kNone.
  uint32_t any(uint32_t position) const noexcept { return newest_[position]; }

  /// Adds a wedge. @param attributes_of  the attributes of each wedge, at least of those added before.
  void add(uint32_t position, uint32_t wedge, std::span<const VertexAttributes> attributes_of) {
    if (before_.size() <= wedge) before_.resize(wedge + 1, kNone);
    before_[wedge] = newest_[position];
    newest_[position] = wedge;
    uint32_t older = wedge;  // the wedge that moves from the list to the hash table
    for (size_t i = 0; i < kListed && older != kNone; ++i) older = before_[older];
    if (older != kNone) older_.emplace(Key{position, attributes_of[older]}, older);
  }

 private:
  static constexpr size_t kListed = 16;

  struct Key {
    uint32_t position;
    VertexAttributes attributes;
    bool operator==(const Key&) const = default;
  };
  struct Hash {
    size_t operator()(const Key& key) const noexcept {
      const VertexAttributes& a = key.attributes;
      const uint64_t low = uint64_t{key.position} << 32 | uint64_t{a.normal} << 16 | a.material,
                     high = uint64_t{std::bit_cast<uint32_t>(a.colour)} << 32 |
                            std::bit_cast<uint32_t>(a.texture);
      return NumberTable::hash(low ^ NumberTable::hash(high));
    }
  };

  std::vector<uint32_t> newest_;  ///< newest wedge of each position
  /// For each added wedge, the previously added wedge of the same position.
  std::vector<uint32_t> before_;
  std::unordered_map<Key, uint32_t, Hash> older_;
};

}  // namespace lode::ingest
