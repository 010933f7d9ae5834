#include "server/http/content_cache.h"

#include <utility>

namespace lode::http {

namespace {

/// Memory of an entry besides its key and content: the nodes of the list and the map.
constexpr uint64_t kEntryBytes = 192;

}  // namespace

/// A content that counts towards the memory limit until its last user releases it.
class ContentCache::Counted {
 public:
  Counted(std::unique_ptr<const Content> content, std::shared_ptr<Memory> memory, uint64_t bytes)
      : content_(std::move(content)), memory_(std::move(memory)), bytes_(bytes) {
    memory_->used.fetch_add(bytes_, std::memory_order_relaxed);
  }
  ~Counted() { memory_->used.fetch_sub(bytes_, std::memory_order_relaxed); }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

  const Content* content() const noexcept { return content_.get(); }

 private:
  const std::unique_ptr<const Content> content_;
  const std::shared_ptr<Memory> memory_;
  const uint64_t bytes_;
};

std::shared_ptr<const Content> ContentCache::find(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto found = by_key_.find(key);
  if (found == by_key_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, found->second);
  return found->second->content;
}

std::shared_ptr<const Content> ContentCache::add(const std::string& key,
                                                 std::unique_ptr<const Content> content) {
  const uint64_t bytes = content->memoryBytes() + key.size() + kEntryBytes;
  const auto counted = std::make_shared<const Counted>(std::move(content), memory_, bytes);
  const std::shared_ptr<const Content> shared(counted, counted->content());
  const std::lock_guard lock(mutex_);
  if (const auto old = by_key_.find(key); old != by_key_.end()) {
    const auto entry = old->second;
    by_key_.erase(old);
    entries_.erase(entry);
  }
  while (usedBytes() > limit_bytes_ && !entries_.empty()) {
    by_key_.erase(entries_.back().key);
    entries_.pop_back();
  }
  if (usedBytes() > limit_bytes_) return nullptr;
  entries_.push_front({key, shared});
  by_key_.emplace(entries_.front().key, entries_.begin());
  return shared;
}

}  // namespace lode::http
