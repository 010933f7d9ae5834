#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "server/serve/ops/counter.h"

namespace lode::serve {

/// Why a client was not let in: the first four at the door, the others and, behind a balancer, its address
/// once it was accepted.
enum class RefusalReason : uint8_t {
  kConnections,  ///< --max-connections
  kAddress,      ///< --max-connections-per-address
  kMemory,       ///< --memory-budget
  kDescriptors,  ///< the system's limit of open files
  kToken,        ///< none, unknown or expired
  kProxyHeader,  ///< with --proxy-protocol
  kTls,          ///< the handshake failed
};
constexpr size_t kRefusalReasons = 7;
std::string_view refusalName(RefusalReason reason) noexcept;

/// Why a connection that was accepted has ended.
enum class EndReason : uint8_t {
  kClient,       ///< it closed
  kBroken,       ///< reset, or gone in the middle of a frame
  kProxyHeader,  ///< the balancer's header was missing or wrong
  kTls,          ///< the handshake failed
  kMistake,      ///< it broke a rule of the protocol
  kHandshake,    ///< no Hello in time
  kIdle,         ///< no frame in time
  kStalled,      ///< it took nothing in time
  kMemory,       ///< the greediest, when the budget was used up
  kStopping,
};
constexpr size_t kEndReasons = 10;
std::string_view endName(EndReason reason) noexcept;

constexpr size_t kRequestClasses = 3;

/// What one model has cost one thread.
struct ModelCounters {
  Counter opened, blobs, bytes, cold_reads, damaged;
};

/// What one thread of the server counts; it alone adds, whoever asks for the metrics reads.
class ThreadCounters {
 public:
  Counter accepted;  ///< past the door, whatever they said then
  std::array<Counter, kRefusalReasons> refused;
  std::array<Counter, kEndReasons> ended;
  std::array<Counter, kRequestClasses> requests;
  std::array<LatencyCounter, kRequestClasses>
      queue;  ///< from a request to its first chunk, but for what is held
  std::array<LatencyCounter, kRequestClasses> held;  ///< of that time, what the client has held it up
  std::array<LatencyCounter, kRequestClasses> send;  ///< from a request to its last chunk

  /// The tallies of a model, by its name; they stay where they are. Takes a lock: ask once an Open.
  ModelCounters& model(const std::string& name);
  template <typename Visit>  ///< visit(name, tallies)
  void forEachModel(const Visit& visit) const {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, counters] : models_) visit(name, counters);
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, ModelCounters> models_;
};

/// What is so at the moment, beside what was counted.
struct ServerGauges {
  uint64_t connections = 0, models = 0;
  uint64_t certificate_expires_s = 0;  ///< Unix time; 0: there is none
  uint64_t memory_bytes = 0, memory_budget_bytes = 0, allocated_bytes = 0;
  uint64_t log_lines_dropped = 0, log_lines_left_out = 0;
  bool stopping = false;
};

/// The tallies of all threads. Thread safe but for what ThreadCounters says.
class Metrics {
 public:
  /// @param threads  that count.
  explicit Metrics(size_t threads);

  ThreadCounters& ofThread(size_t thread) noexcept { return *threads_[thread]; }
  /// All of it summed, in Prometheus' text format 0.0.4.
  std::string text(const ServerGauges& gauges) const;

 private:
  std::vector<std::unique_ptr<ThreadCounters>> threads_;
};

}  // namespace lode::serve
