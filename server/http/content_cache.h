#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace lode::http {

/// Data that the server computes to answer requests, such as the bytes of a file. Immutable.
class Content {
 public:
  virtual ~Content() = default;
  /// Returns the memory that this object uses.
  virtual uint64_t memoryBytes() const noexcept = 0;
};

/// The bytes of a resource.
class FileContent : public Content {
 public:
  /// @param packed  the same bytes compressed by gzip, or empty.
  FileContent(std::vector<std::byte> plain, std::vector<std::byte> packed)
      : plain_(std::move(plain)), packed_(std::move(packed)) {}
  /// @param constant  bytes that live as long as the program, so that they are not copied.
  FileContent(std::span<const std::byte> constant, std::vector<std::byte> packed)
      : constant_(constant), packed_(std::move(packed)) {}

  std::span<const std::byte> plain() const noexcept {
    return plain_.empty() ? constant_ : std::span<const std::byte>(plain_);
  }
  std::span<const std::byte> packed() const noexcept { return packed_; }
  uint64_t memoryBytes() const noexcept override {
    return sizeof *this + plain_.capacity() + packed_.capacity();
  }

 private:
  std::span<const std::byte> constant_;
  std::vector<std::byte> plain_, packed_;
};

/// Caches contents by key, and evicts the least recently used. An evicted content counts towards the limit
/// until the last response that uses it ends, so that slow clients cannot make the server exceed the limit.
/// Thread safe.
class ContentCache {
 public:
  explicit ContentCache(uint64_t limit_bytes)
      : memory_(std::make_shared<Memory>()), limit_bytes_(limit_bytes) {}

  /// Returns a content, or null. The content becomes the last to be evicted.
  std::shared_ptr<const Content> find(const std::string& key);

  /// Adds a content and evicts others, least recently used first. @return the content, or null if responses
  /// still use so many evicted contents that the new one does not fit.
  std::shared_ptr<const Content> add(const std::string& key, std::unique_ptr<const Content> content);

  /// Evicts each content if `is_stale` returns true for its key.
  template <typename Predicate>
  void eraseIf(const Predicate& is_stale) {
    std::list<Entry> removed;
    const std::lock_guard lock(mutex_);
    for (auto entry = entries_.begin(); entry != entries_.end();) {
      const auto next = std::next(entry);
      if (is_stale(entry->key)) {
        by_key_.erase(entry->key);
        removed.splice(removed.end(), entries_, entry);
      }
      entry = next;
    }
  }

  uint64_t limitBytes() const noexcept { return limit_bytes_; }
  uint64_t usedBytes() const noexcept { return memory_->used.load(std::memory_order_relaxed); }

 private:
  /// Memory of all contents. Outlives the cache if a response still uses a content.
  struct Memory {
    std::atomic<uint64_t> used{0};
  };
  class Counted;
  struct Entry {
    std::string key;
    std::shared_ptr<const Content> content;
  };

  const std::shared_ptr<Memory> memory_;
  const uint64_t limit_bytes_;
  std::mutex mutex_;
  std::list<Entry> entries_;                                                 ///< most recently used first
  std::unordered_map<std::string_view, std::list<Entry>::iterator> by_key_;  ///< keys are parts of entries_
};

}  // namespace lode::http
