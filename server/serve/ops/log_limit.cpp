#include "server/serve/ops/log_limit.h"

#include <algorithm>
#include <utility>

namespace lode::serve {

LogLimit::Bucket& LogLimit::fill(LogKind kind, TimePoint now) noexcept {
  Bucket& bucket = buckets_[static_cast<size_t>(kind)];
  const double seconds = std::chrono::duration<double>(std::max(now, bucket.filled) - bucket.filled).count();
  bucket.lines = std::min(kBurst, bucket.lines + seconds * kPerSecond);
  bucket.filled = std::max(now, bucket.filled);
  return bucket;
}

bool LogLimit::admit(LogKind kind, TimePoint now) noexcept {
  Bucket& bucket = fill(kind, now);
  if (bucket.lines < 1) {
    ++bucket.left_out;
    return false;
  }
  bucket.lines -= 1;
  return true;
}

uint64_t LogLimit::takeLeftOut(LogKind kind, TimePoint now) noexcept {
  Bucket& bucket = fill(kind, now);
  return bucket.left_out > 0 && bucket.lines >= 1 ? std::exchange(bucket.left_out, 0) : 0;
}

}  // namespace lode::serve
