#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lode::ingest {

/// Set of vertex numbers, stored as a bitmap, with at most 2^32 - 1 members. A member's rank is the number of
/// smaller members. A caller that reads the data of all members in one sweep can index the data by rank,
/// without sorting. rank() counts the bits of only one word, because the set stores the rank of each word's
/// first member.
class VertexSet {
 public:
  explicit VertexSet(uint64_t vertices) : words_((vertices + 63) / 64) {}

  /// Adds a vertex. @return true if the vertex is new.
  bool add(uint64_t vertex) noexcept {
    uint64_t& word = words_[vertex / 64];
    const uint64_t bit = uint64_t{1} << vertex % 64;
    const bool is_new = (word & bit) == 0;
    word |= bit;
    return is_new;
  }
  bool contains(uint64_t vertex) const noexcept { return (words_[vertex / 64] >> vertex % 64 & 1) != 0; }
  /// Returns true if any of the vertices 64 * word .. 64 * word + 63 is a member.
  bool anyInWord(uint64_t word) const noexcept { return words_[word] != 0; }
  uint64_t wordCount() const noexcept { return words_.size(); }
  void clear() { words_.assign(words_.size(), 0); }

  /// Prepares rank(). Call once, when the set is complete. @return the number of members.
  uint32_t countRanks() {
    ranks_.resize(words_.size());
    uint32_t members = 0;
    for (size_t w = 0; w < words_.size(); ++w) {
      ranks_[w] = members;
      members += static_cast<uint32_t>(std::popcount(words_[w]));
    }
    return members;
  }
  uint32_t rank(uint64_t vertex) const noexcept {
    const uint64_t below = words_[vertex / 64] & ((uint64_t{1} << vertex % 64) - 1);
    return ranks_[vertex / 64] + static_cast<uint32_t>(std::popcount(below));
  }

 private:
  std::vector<uint64_t> words_;
  std::vector<uint32_t> ranks_;
};

}  // namespace lode::ingest
