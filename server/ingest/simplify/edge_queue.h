#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lode::ingest {

/// Priority queue with buckets. The exponent and the four most significant fraction bits of a key select the
/// bucket, so the keys in a bucket differ by at most 1/16. Items leave a bucket in the order of their
/// arrival. A bucket is a chain of small blocks, so that the queue reads items sequentially and can prefetch
/// them.
template <typename Item>
class EdgeQueue {
 public:
  EdgeQueue() { clear(); }

  void clear() {
    blocks_.clear();
    free_ = kNone;
    chains_.fill({});
    occupied_.fill(0);
    current_ = 0;
  }

  /// Reserves memory for `items` items.
  void reserve(size_t items) { blocks_.reserve(items / kBlock + kUsualBuckets); }

  /// @param key  finite, not negative
  static uint32_t bucketOf(float key) noexcept { return std::bit_cast<uint32_t>(key) >> kDroppedBits; }

  /// Returns the bucket of the item that pop() returned last.
  uint32_t current() const noexcept { return current_; }

  void push(const Item& item, float key) {
    const uint32_t bucket = bucketOf(key);
    Chain& chain = chains_[bucket];
    if (chain.last == kNone) {
      chain.first = chain.last = newBlock();
      chain.begin = chain.end = 0;
      occupied_[bucket / 64] |= uint64_t{1} << bucket % 64;
    } else if (chain.end == kBlock) {
      const uint32_t block = newBlock();
      blocks_[chain.last].next = block;
      chain.last = block;
      chain.end = 0;
    }
    blocks_[chain.last].items[chain.end++] = item;
    current_ = std::min(current_, bucket);
  }

  /// Takes an item from the non-empty bucket with the smallest keys. Returns false if the queue is empty.
  /// @param soon  called with an item that will leave the queue a few calls later, so that its data can be
  /// prefetched; may change the item
  template <typename Soon>
  bool pop(Item& item, Soon&& soon) noexcept {
    if (chains_[current_].first == kNone && !advance()) return false;
    Chain& chain = chains_[current_];
    Block& block = blocks_[chain.first];
    item = block.items[chain.begin++];
    const bool last = chain.first == chain.last;
    const uint32_t end = last ? chain.end : kBlock, ahead = chain.begin + kAhead;
    if (ahead < end) {
      soon(block.items[ahead]);
    } else if (!last && (block.next != chain.last || ahead - kBlock < chain.end)) {
      soon(blocks_[block.next].items[ahead - kBlock]);
    }
    if (chain.begin < end) return true;
    const uint32_t used = chain.first;
    if (last) {
      chain = {};
      occupied_[current_ / 64] &= ~(uint64_t{1} << current_ % 64);
    } else {
      chain.first = block.next;
      chain.begin = 0;
    }
    blocks_[used].next = free_;
    free_ = used;
    return true;
  }

 private:
  static constexpr uint32_t kNone = ~0u;
  // Number of low fraction bits that do not affect the bucket; a float has 23.
  static constexpr uint32_t kDroppedBits = 19;
  static constexpr size_t kBuckets = 1u << (31 - kDroppedBits);  // 31, because keys have no sign bit
  static constexpr size_t kWords = kBuckets / 64;
  static constexpr uint32_t kBlock = 30;
  static constexpr size_t kUsualBuckets = 512;  // typical number of occupied buckets
  static constexpr uint32_t kAhead = 6;

  struct Block {
    std::array<Item, kBlock> items;
    uint32_t next;
  };
  struct Chain {
    uint32_t first = kNone, last = kNone;  // first and last block of the bucket
    // Index of the first item in the first block, and end of the items in the last block.
    uint32_t begin = 0, end = 0;
  };

  bool advance() noexcept {
    size_t word = current_ / 64;
    uint64_t bits = occupied_[word] & ~uint64_t{0} << current_ % 64;
    while (bits == 0) {
      if (++word == kWords) return false;
      bits = occupied_[word];
    }
    current_ = static_cast<uint32_t>(64 * word) + static_cast<uint32_t>(std::countr_zero(bits));
    return true;
  }

  uint32_t newBlock() {
    uint32_t block = free_;
    if (block == kNone) {
      block = static_cast<uint32_t>(blocks_.size());
      blocks_.emplace_back();
    } else {
      free_ = blocks_[block].next;
    }
    return block;
  }

  std::vector<Block> blocks_;
  uint32_t free_;
  std::array<Chain, kBuckets> chains_;
  std::array<uint64_t, kWords> occupied_;
  uint32_t current_;
};

}  // namespace lode::ingest
