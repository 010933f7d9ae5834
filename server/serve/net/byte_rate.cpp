#include "server/serve/net/byte_rate.h"

#include <algorithm>

namespace lode::serve {

using std::chrono::nanoseconds;

ByteRate::ByteRate(uint64_t bytes_per_second) noexcept
    : ns_per_byte_(bytes_per_second == 0 ? 0 : 1e9 / static_cast<double>(bytes_per_second)) {}

ByteRate::Clock::time_point ByteRate::take(uint64_t bytes, Clock::time_point now) noexcept {
  if (!limited()) return now;
  const int64_t earliest = nanoseconds(now.time_since_epoch() - kGrace).count();
  int64_t next = next_ns_.load(std::memory_order_relaxed), turn = 0;
  do {
    turn = std::max(next, earliest);
  } while (!next_ns_.compare_exchange_weak(next, turn + lastingNs(bytes), std::memory_order_relaxed));
  return Clock::time_point(std::chrono::duration_cast<Clock::duration>(nanoseconds(turn)));
}

void ByteRate::give(uint64_t bytes) noexcept {
  next_ns_.fetch_sub(lastingNs(bytes), std::memory_order_relaxed);
}

}  // namespace lode::serve
