#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "common/lattice.h"

namespace lode::ingest {

/// Open-addressing hash table from 64-bit keys to 32-bit numbers. Does not support iteration, so results
/// cannot depend on the order of keys. Use one table for many nodes, to reuse its memory.
class NumberTable {
 public:
  static constexpr uint32_t kAbsent = UINT32_MAX;

  /// Clears the table. @param expected  number of keys for which memory is reserved; the table grows if more
  /// keys follow.
  void reset(size_t expected) {
    const size_t wanted = std::bit_ceil(std::max<size_t>(expected, 8) * 2);
    if (slots_.size() < wanted) slots_.resize(wanted);
    mask_ = wanted - 1;
    count_ = 0;
    for (size_t i = 0; i < wanted; ++i) slots_[i].number = kAbsent;
  }

  /// Returns the number of a key; a new key gets `number`.
  uint32_t findOrAdd(uint64_t key, uint32_t number) {
    const size_t at = slotOf(key);
    if (slots_[at].number != kAbsent) return slots_[at].number;
    slots_[at] = {key, number};
    if (++count_ * 2 > mask_ + 1) grow();
    return number;
  }

  /// Finalizer of MurmurHash3 (Appleby, public domain). Every bit of the key affects every bit of the hash,
  /// so that neighbouring lattice points get distant slots.
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

  /// Returns the slot of a key, or the free slot in which a new key belongs.
  size_t slotOf(uint64_t key) const noexcept {
    size_t at = hash(key) & mask_;
    while (slots_[at].number != kAbsent && slots_[at].key != key) at = (at + 1) & mask_;
    return at;
  }

  void grow() {
    const std::vector<Slot> before(slots_.begin(), slots_.begin() + static_cast<ptrdiff_t>(mask_ + 1));
    const size_t keys = count_;
    reset(mask_ + 1);
    count_ = keys;
    for (const Slot& slot : before)
      if (slot.number != kAbsent) slots_[slotOf(slot.key)] = slot;
  }

  std::vector<Slot> slots_;
  size_t mask_ = 0, count_ = 0;
};

}  // namespace lode::ingest
