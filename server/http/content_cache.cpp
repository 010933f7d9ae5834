#include "server/http/content_cache.h"

#include <utility>

namespace lode::http {

namespace {

/// Memory of an entry besides its key and content: the nodes of the list and the map.
constexpr uint64_t kEntryBytes = 192;

}  // namespace

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
  memory_->used.fetch_add(bytes, std::memory_order_relaxed);
  const std::shared_ptr<const Content> shared(content.release(),
                                              [memory = memory_, bytes](const Content* gone) {
                                                delete gone;
                                                memory->used.fetch_sub(bytes, std::memory_order_relaxed);
                                              });
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
