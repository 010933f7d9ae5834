#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace lode::ingest {

/// Items by rising key, first come first served among keys that differ by less than 1/16: keys fall into the
/// buckets that their exponent and four highest fraction bits make. Constant time, no allocation while it
/// runs. An item is a number below `capacity` and is in the queue once at most.
class EdgeQueue {
 public:
  static constexpr uint32_t kNone = ~0u;

  void reset(size_t capacity) {
    next_.assign(capacity, kNone);
    heads_.fill(kNone);
    tails_.fill(kNone);
    occupied_.fill(0);
    current_ = 0;
  }

  /// @param key  finite, not negative
  static uint32_t bucketOf(float key) noexcept { return std::bit_cast<uint32_t>(key) >> kDroppedBits; }

  /// The bucket of the item that pop() gave last.
  uint32_t current() const noexcept { return current_; }

  void push(uint32_t item, float key) noexcept {
    const uint32_t bucket = bucketOf(key);
    next_[item] = kNone;
    if (heads_[bucket] == kNone) {
      heads_[bucket] = item;
      occupied_[bucket / 64] |= uint64_t{1} << bucket % 64;
    } else {
      next_[tails_[bucket]] = item;
    }
    tails_[bucket] = item;
    current_ = std::min(current_, bucket);
  }

  /// An item of the lowest occupied bucket, or kNone.
  uint32_t pop() noexcept {
    while (heads_[current_] == kNone) {
      size_t word = current_ / 64;
      uint64_t bits = occupied_[word] & ~uint64_t{0} << current_ % 64;
      while (bits == 0) {
        if (++word == kWords) return kNone;
        bits = occupied_[word];
      }
      current_ = static_cast<uint32_t>(64 * word) + static_cast<uint32_t>(std::countr_zero(bits));
    }
    const uint32_t item = heads_[current_];
    heads_[current_] = next_[item];
    if (heads_[current_] == kNone) occupied_[current_ / 64] &= ~(uint64_t{1} << current_ % 64);
    return item;
  }

 private:
  static constexpr uint32_t kDroppedBits = 19;                   // of the 23 of a float's fraction
  static constexpr size_t kBuckets = 1u << (31 - kDroppedBits);  // no sign
  static constexpr size_t kWords = kBuckets / 64;

  std::vector<uint32_t> next_;
  std::array<uint32_t, kBuckets> heads_{}, tails_{};
  std::array<uint64_t, kWords> occupied_{};
  uint32_t current_ = 0;
};

}  // namespace lode::ingest
