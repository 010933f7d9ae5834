#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <random>
#include <span>
#include <string>

#include <glm/glm.hpp>

#include "client/core/session/session.h"
#include "client/core/view/time_point.h"
#include "client/loadtest/load_counts.h"
#include "client/loadtest/request_trace.h"
#include "client/net/address.h"
#include "client/stream/streamer.h"
#include "common/codec/blob.h"
#include "common/error.h"

namespace lode::app {

/// Converts seconds to a duration of the clock.
inline core::TimePoint::duration ofSeconds(double count) {
  return std::chrono::duration_cast<core::TimePoint::duration>(std::chrono::duration<double>(count));
}

/// Settings of the clients of one model in a load test.
struct LoadPlan {
  stream::ServedModel model;
  stream::StreamOptions options;
  net::Route route;    ///< route to the model's server
  RequestTrace trace;  ///< trace that the trace clients replay
  /// Returns the camera path of a full client, which may depend on the client's seed.
  std::function<core::CameraPath(const ModelSummary&, uint64_t seed)> path_of;
  glm::uvec2 size_px{1280, 720};
  float pixels = 1;
  double fps = 10;
  double think_s = 0;  ///< mean pause after each round of the path or trace
  bool decode = true;
  core::TimePoint end{};
};

/// Returns a random pause with exponential distribution.
inline double randomPause(double mean_s, std::mt19937_64& random) {
  return -mean_s * std::log1p(-static_cast<double>(random() >> 11) * 0x1p-53);
}

/// Largest number of checksums that KnownDigests remembers. When it is reached, KnownDigests forgets them
/// all.
constexpr size_t kMaxKnownDigests = 1u << 17;

/// Checks the digests of blobs that arrive repeatedly. Computes the SHA-256 of the first copy of a blob.
/// Compares the xxh3 checksums of later copies with that of the first, because xxh3 is faster than SHA-256.
/// Not thread safe.
class KnownDigests {
 public:
  bool matchesDigest(const BlobRef& blob, std::span<const std::byte> bytes);
  size_t size() const noexcept { return checksums_.size(); }

 private:
  std::map<Digest, uint64_t> checksums_;  ///< xxh3 checksums of blobs whose digests were verified
};

constexpr auto kNever = core::TimePoint::max();

/// A client of a load test. Runs on the thread of its io_context.
class LoadClient {
 public:
  virtual ~LoadClient() = default;

  /// Returns the time of the next step(); kNever after the client has ended.
  virtual core::TimePoint due() const noexcept = 0;
  /// Connects or reconnects, sends the due requests, and keeps the connection alive.
  virtual void step(core::TimePoint now) = 0;
  /// Ends the client. Counts each open request with its latency so far.
  virtual void finish(core::TimePoint now) = 0;
};

/// Runs an action of a client. Counts an exception as an error that ends the client.
/// @return false if the client ends.
template <typename Action>
bool survives(LoadCounts& counts, const Action& action) {
  try {
    action();
    return true;
  } catch (const Error& error) {
    counts.noteError(error);
  } catch (const std::exception& error) {
    counts.noteError(Error(ErrorCode::kInternal, error.what()));
  }
  ++counts.gave_up;
  return false;
}

/// Counts an error for a client that no server accepted until the end of the test.
/// @param why  last reason of the server; its text is empty if the server did not turn the client away.
inline void noteNeverLetIn(LoadCounts& counts, const core::ServerLeaving& why) {
  if (why.reason.empty()) return;
  counts.noteError(Error(ErrorCode::kNetwork, "no server accepted the client: " + why.reason, why.remedy));
}

}  // namespace lode::app
