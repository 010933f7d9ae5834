#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace lode::serve {

/// A counter that one thread increments and any thread reads, without locks or atomic read-modify-write
/// instructions.
class Counter {
 public:
  void add(uint64_t more = 1) noexcept {
    value_.store(value_.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
  }
  uint64_t read() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<uint64_t> value_{0};
};

/// Upper bounds of the latency buckets in seconds. One more bucket counts longer latencies.
constexpr std::array kLatencyBoundsSeconds{0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02,
                                           0.05,   0.1,    0.2,    0.5,   1.0,   2.0,   5.0,  10.0};

/// A histogram of durations. One thread adds durations; any thread can read the histogram.
class LatencyCounter {
 public:
  static constexpr size_t kBuckets = kLatencyBoundsSeconds.size() + 1;

  void add(std::chrono::nanoseconds duration) noexcept {
    const double seconds = std::chrono::duration<double>(duration).count();
    size_t bucket = 0;
    while (bucket < kLatencyBoundsSeconds.size() && seconds > kLatencyBoundsSeconds[bucket]) ++bucket;
    buckets_[bucket].add();
    sum_ns_.add(duration.count() > 0 ? static_cast<uint64_t>(duration.count()) : 0);
  }
  uint64_t bucket(size_t number) const noexcept { return buckets_[number].read(); }
  uint64_t sumNs() const noexcept { return sum_ns_.read(); }

 private:
  std::array<Counter, kBuckets> buckets_;
  Counter sum_ns_;
};

/// Reason for refusing a connection. The first four reasons apply at accept(), the others later. Behind a
/// balancer, kAddress applies only after the balancer's header has arrived.
enum class RefusalReason : uint8_t {
  kConnections,  ///< --max-connections is reached
  kAddress,      ///< --max-connections-per-address is reached
  kMemory,       ///< the memory budget (--memory-budget) is used up
  kDescriptors,  ///< the process has reached its limit of open files
  kToken,        ///< the token is missing, unknown or expired
  kProxyHeader,  ///< --proxy-protocol is set and the balancer's header is missing or malformed
  kTls,          ///< the handshake failed
};
constexpr size_t kRefusalReasons = 7;
std::string_view refusalName(RefusalReason reason) noexcept;

/// Reason why an accepted connection ended.
enum class EndReason : uint8_t {
  kClient,       ///< the client closed the connection
  kBroken,       ///< the connection was reset, or closed within a frame
  kProxyHeader,  ///< the balancer's header was missing or malformed
  kTls,          ///< the handshake failed
  kMistake,      ///< the client broke a rule of the protocol
  kHandshake,    ///< the client sent no Hello before the deadline
  kIdle,         ///< the client sent no frame within the idle deadline
  kStalled,      ///< the client received no bytes before the write deadline
  kMemory,       ///< the memory budget ran short and the connection was one of the largest
  kStopping,
};
constexpr size_t kEndReasons = 10;
std::string_view endName(EndReason reason) noexcept;

constexpr size_t kRequestClasses = 3;

/// Statuses of HTTP responses.
constexpr std::array kHttpStatuses{101, 200, 204, 206, 304, 400, 401, 403, 404, 405,
                                   413, 416, 421, 426, 429, 431, 500, 503, 505};

/// Counters of one model on one thread.
struct ModelCounters {
  Counter opened, blobs, bytes, cold_reads, damaged, unreadable;
};

/// Counters of one thread of the server. That thread alone increments them; Metrics::text() reads them.
class ThreadCounters {
 public:
  Counter accepted;  ///< accepted connections, whether or not TLS and Hello succeed later
  std::array<Counter, kRefusalReasons> refused;
  std::array<Counter, kEndReasons> ended;
  std::array<Counter, kRequestClasses> requests;
  /// Time from a request to its first chunk, without the time in `held`.
  std::array<LatencyCounter, kRequestClasses> queue;
  /// Time from a request to its first chunk during which the client could not receive a chunk.
  std::array<LatencyCounter, kRequestClasses> held;
  std::array<LatencyCounter, kRequestClasses> send;          ///< time from a request to its last chunk
  std::array<Counter, kHttpStatuses.size()> http_responses;  ///< by kHttpStatuses
  Counter http_sent_bytes;                                   ///< heads and bodies of HTTP responses

  /// Counts a response. @param status  one of kHttpStatuses; others are not counted.
  void countHttpResponse(int status) noexcept {
    const auto found = std::ranges::find(kHttpStatuses, status);
    if (found != kHttpStatuses.end())
      http_responses[static_cast<size_t>(found - kHttpStatuses.begin())].add();
  }

  /// Returns the counters of a model. The reference stays valid. Call model() once per Open, because it locks
  /// a mutex.
  ModelCounters& model(const std::string& name);
  template <typename Visit>  ///< visit(name, counters)
  void forEachModel(const Visit& visit) const {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, counters] : models_) visit(name, counters);
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, ModelCounters> models_;
};

/// Current values that are not sums of counters.
struct ServerGauges {
  uint64_t connections = 0, models = 0;
  uint64_t models_skipped = 0;         ///< stores that could not be opened at the start or at the last reload
  uint64_t certificate_expires_s = 0;  ///< Unix time at which the certificate expires; 0 without one
  uint64_t memory_bytes = 0, memory_budget_bytes = 0, allocated_bytes = 0;
  uint64_t log_lines_dropped = 0, log_lines_left_out = 0;
  /// Memory of HTTP contents, their limit (0 without HTTP), and the number of contents made.
  uint64_t http_cache_bytes = 0, http_cache_limit_bytes = 0, http_contents_made = 0;
  bool stopping = false;
};

/// Counters of all threads. Thread safe, except that only one thread can write to each ThreadCounters.
class Metrics {
 public:
  /// @param threads  number of threads that count.
  explicit Metrics(size_t threads);

  ThreadCounters& ofThread(size_t thread) noexcept { return *threads_[thread]; }
  /// Returns the sums over all threads in Prometheus' text format 0.0.4.
  std::string text(const ServerGauges& gauges) const;

 private:
  std::vector<std::unique_ptr<ThreadCounters>> threads_;
};

}  // namespace lode::serve
