#include "client/core/cache/cache_queries.h"

namespace lode::core {

bool CacheQueries::isMissing(const Request& request) {
  if (misses_.contains(request.blob.digest)) return true;
  if (asked_.size() >= kMaxCacheQueries) return false;
  if (asked_.try_emplace(request.blob.digest, request.use).second) new_.push_back(request.blob);
  return false;
}

std::optional<BlobUse> CacheQueries::finish(const BlobRef& blob, bool found) {
  const auto asked = asked_.find(blob.digest);
  if (asked == asked_.end()) return std::nullopt;
  const BlobUse use = asked->second;
  asked_.erase(asked);
  if (!found) {
    if (misses_.size() >= kMaxRememberedMisses) misses_.clear();
    misses_.insert(blob.digest);
  }
  return use;
}

}  // namespace lode::core
