#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "common/lattice.h"

namespace lode::ingest {

/// Open-addressing hash table from a 64-bit key to a 32-bit number; the keys' order never shows. Reused
/// between nodes so that its memory is taken once.
class NumberTable {
 public:
  static constexpr uint32_t kAbsent = UINT32_MAX;

  void reset(size_t expected) {
    const size_t wanted = std::bit_ceil(expected * 2 + 16);
    if (slots_.size() < wanted) slots_.resize(wanted);
    mask_ = wanted - 1;
    for (size_t i = 0; i < wanted; ++i) slots_[i].number = kAbsent;
  }

  /// The number of a key, after entering `number` for it if it had none.
  uint32_t findOrAdd(uint64_t key, uint32_t number) noexcept {
    size_t at = hash(key) & mask_;
    while (slots_[at].number != kAbsent) {
      if (slots_[at].key == key) return slots_[at].number;
      at = (at + 1) & mask_;
    }
    slots_[at] = {key, number};
    return number;
  }

  uint32_t find(uint64_t key) const noexcept {
    size_t at = hash(key) & mask_;
    while (slots_[at].number != kAbsent) {
      if (slots_[at].key == key) return slots_[at].number;
      at = (at + 1) & mask_;
    }
    return kAbsent;
  }

  /// Finalizer of MurmurHash3 (Appleby, public domain): full avalanche, so that lattice neighbours spread.
  static constexpr uint64_t hash(uint64_t x) noexcept {
    x = (x ^ x >> 33) * 0xff51afd7ed558ccdULL;
    x = (x ^ x >> 33) * 0xc4ceb9fe1a85ec53ULL;
    return x ^ x >> 33;
  }

 private:
  struct Slot {
    uint64_t key;
    uint32_t number;
  };
  std::vector<Slot> slots_;
  size_t mask_ = 0;
};

}  // namespace lode::ingest
