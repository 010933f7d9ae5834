#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace lode::serve {

/// What a line of the log is about; each kind is limited by itself.
enum class LogKind : uint8_t {
  kServer,           ///< started, stopping, reloaded
  kConnectionEnd,    ///< one line a connection
  kRefused,          ///< a connection that was not let in, and why
  kUnauthorized,     ///< a token that is unknown or has expired
  kProtocolMistake,  ///< a client that broke a rule
  kDamagedStore,     ///< a blob that does not match its checksum, a store that changed
  kSystem,           ///< the operating system refused: read, accept, memory
};
constexpr size_t kLogKinds = 7;

/// Bounds the lines of each kind: kBurst at once, then kPerSecond. Not thread safe.
class LogLimit {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  static constexpr double kBurst = 50, kPerSecond = 5;

  /// Whether a line of this kind may be written now; otherwise it is counted as left out.
  bool admit(LogKind kind, TimePoint now) noexcept;
  /// How many lines of this kind were left out, once one may be written again; counts anew. 0 until then.
  uint64_t takeLeftOut(LogKind kind, TimePoint now) noexcept;

 private:
  struct Bucket {
    double lines = kBurst;
    TimePoint filled{};
    uint64_t left_out = 0;
  };
  Bucket& fill(LogKind kind, TimePoint now) noexcept;
  std::array<Bucket, kLogKinds> buckets_;
};

}  // namespace lode::serve
