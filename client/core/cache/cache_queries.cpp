#include "client/core/cache/cache_queries.h"

namespace lode::core {

bool CacheQueries::isMissing(const Request& request, uint64_t most_bytes) {
  const BlobRef& blob = request.blob;
  if (misses_.contains(blob.digest)) return true;
  if (asked_.size() >= kMaxCacheQueries) return false;
  if (!asked_.empty() && asked_bytes_ + blob.bytes > most_bytes) return false;
  if (!asked_.try_emplace(blob.digest, Query{request.use, blob.bytes}).second) return false;
  asked_bytes_ += blob.bytes;
  new_.push_back(blob);
  return false;
}

std::optional<BlobUse> CacheQueries::finish(const BlobRef& blob, bool found) {
  const auto asked = asked_.find(blob.digest);
  if (asked == asked_.end()) return std::nullopt;
  const BlobUse use = asked->second.use;
  asked_bytes_ -= asked->second.bytes;
  asked_.erase(asked);
  if (!found) {
    if (misses_.size() >= kMaxRememberedMisses) misses_.clear();
    misses_.insert(blob.digest);
  }
  return use;
}

}  // namespace lode::core
