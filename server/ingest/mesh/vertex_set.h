#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lode::ingest {

/// A set of vertex numbers as a bitmap, with the rank of each member: its place among the members in rising
/// order. An array of the members' data, read in one sweep, is then looked up without a sort.
class VertexSet {
 public:
  explicit VertexSet(uint64_t vertices)
      : words_((vertices + 63) / 64), ranks_(words_.size() / kWordsPerRank + 1) {}

  /// @return true if the vertex was not in the set yet.
  bool add(uint64_t vertex) noexcept {
    uint64_t& word = words_[vertex / 64];
    const uint64_t bit = uint64_t{1} << vertex % 64;
    const bool is_new = (word & bit) == 0;
    word |= bit;
    return is_new;
  }
  bool contains(uint64_t vertex) const noexcept { return (words_[vertex / 64] >> vertex % 64 & 1) != 0; }
  /// True if any of vertices 64 * word .. 64 * word + 63 is a member.
  bool anyInWord(uint64_t word) const noexcept { return words_[word] != 0; }
  uint64_t wordCount() const noexcept { return words_.size(); }
  void clear() { words_.assign(words_.size(), 0); }

  /// To be called when the set is complete, before rank(). @return the number of members.
  uint64_t countRanks() noexcept {
    uint64_t members = 0;
    for (size_t w = 0; w < words_.size(); ++w) {
      if (w % kWordsPerRank == 0) ranks_[w / kWordsPerRank] = members;
      members += static_cast<uint64_t>(std::popcount(words_[w]));
    }
    return members;
  }
  uint64_t rank(uint64_t vertex) const noexcept {
    const uint64_t word = vertex / 64;
    uint64_t rank = ranks_[word / kWordsPerRank];
    for (uint64_t w = word / kWordsPerRank * kWordsPerRank; w < word; ++w) {
      rank += static_cast<uint64_t>(std::popcount(words_[w]));
    }
    return rank + static_cast<uint64_t>(std::popcount(words_[word] & ((uint64_t{1} << vertex % 64) - 1)));
  }

 private:
  static constexpr uint64_t kWordsPerRank = 8;
  std::vector<uint64_t> words_;
  std::vector<uint64_t> ranks_;
};

}  // namespace lode::ingest
