#pragma once

#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "client/core/lod/request.h"

namespace lode::core {

constexpr size_t kMaxCacheQueries = 256;        ///< under way at one time
constexpr size_t kMaxRememberedMisses = 65536;  ///< then they are asked for again

/// What is asked of a cache before a server is asked: each blob once, until the answer. Not thread safe.
class CacheQueries {
 public:
  /// True: the cache does not have the blob. False: it is being asked, or will be when others are answered.
  bool lacks(const Request& request);
  /// Blobs to be looked for in the cache; each is to be answered by finish().
  std::vector<BlobRef> take() { return std::exchange(new_, {}); }
  /// @return what the blob was asked for; nothing if it was not, or for a model that is gone.
  std::optional<BlobUse> finish(const BlobRef& blob, bool found);
  /// The blob has come from elsewhere: the cache will have it.
  void arrived(const BlobRef& blob) { misses_.erase(blob.digest); }
  /// Something is on its way from elsewhere, or not to be had.
  bool lacksAny() const noexcept { return !misses_.empty(); }
  bool idle() const noexcept { return asked_.empty(); }

 private:
  std::map<Digest, BlobUse> asked_;
  std::vector<BlobRef> new_;
  std::set<Digest> misses_;
};

}  // namespace lode::core
