#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include <asio/io_context.hpp>

#include "client/app/cli/known_names.h"
#include "client/app/cli/latency_histogram.h"
#include "client/app/cli/wish_trace.h"
#include "client/core/link.h"
#include "client/net/tcp_transport.h"

namespace lode::app {

/// Seconds as steps of the clock.
inline core::TimePoint::duration ofSeconds(double count) {
  return std::chrono::duration_cast<core::TimePoint::duration>(std::chrono::duration<double>(count));
}

/// What the clients of one thread have seen.
struct LoadTally {
  std::array<LatencyHistogram, 3> latency;  ///< by class, from a wish's intended time to its last byte
  LatencyHistogram first_image;             ///< from a client's intended start to the root's coarsest rung
  uint64_t blobs = 0, bytes = 0, errors = 0, unanswered = 0;
  uint64_t moved = 0;  ///< clients that a server told to go away, and who went on with another connection
  uint64_t lost = 0;   ///< connections that broke, or that could not be made anew
  uint64_t failed_wishes = 0;  ///< refused, or open when a connection broke; those were wished for again
  std::string first_error;

  void add(const LoadTally& other);
};

/// What all clients of a load test are told.
struct LoadPlan {
  stream::ServedModel model;
  stream::StreamOptions options;
  net::Route route;  ///< to the model's server
  WishTrace trace;
  bool decode = true;
  core::TimePoint end{};
};

/// One client: it replays the trace over and over from a place of its own in it, each wish at its intended
/// time whether or not those before are there. What is late counts from that time. When its connection ends
/// it comes again, as any client does, and wishes again for what it has not got. Lives on the thread that
/// runs its context.
class LoadClient {
 public:
  /// @param start    when it connects. @param phase_s  where in the trace it begins.
  /// @param names    of the clients of its thread.
  LoadClient(asio::io_context& io, const LoadPlan& plan, core::TimePoint start, double phase_s,
             KnownNames& names, LoadTally& tally);

  /// When step() has something to do next; the end of time if never.
  core::TimePoint due() const noexcept { return due_; }
  /// Connects, also anew, wishes for what is due, keeps the connection alive.
  void step(core::TimePoint now);
  /// What is not there yet counts as late as it is.
  void finish(core::TimePoint now);

 private:
  struct Pending {
    core::Wish wish;
    core::TimePoint intended;
    size_t traced = 0;  ///< its place in the trace
  };

  using Transport = std::unique_ptr<net::TcpTransport>;

  core::SessionOptions sessionOptions();
  Transport& transport(core::Line line) noexcept { return line == core::Line::kNewest ? newest_ : leaving_; }
  template <typename Action>
  void guarded(const Action& action);
  template <typename Action>
  void onLine(core::Line line, core::TimePoint now, const Action& action);
  void noteError(const std::string& what);
  void connect(core::TimePoint now);
  void send();
  void receive();
  void handle(const core::SessionEvent& event, core::Session& session, core::TimePoint now);
  void arrived(const core::BlobArrived& blob, core::Session& session, core::TimePoint now);
  void addDueWishes(core::TimePoint now);
  void sendWishes();
  void scheduleNext(core::TimePoint now);
  core::TimePoint intendedTime(uint64_t replay) const noexcept;

  asio::io_context& io_;
  const LoadPlan& plan_;
  KnownNames& names_;
  LoadTally& tally_;
  const core::TimePoint start_;
  size_t first_;           ///< place in the trace at which it begins
  uint64_t replayed_ = 0;  ///< wishes that were due so far
  core::TimePoint due_;
  core::Link link_;
  std::map<uint32_t, Pending> pending_;  ///< by blob number
  bool image_seen_ = false, gone_ = false;
  uint32_t first_rung_ = 0;  ///< number of the blob that makes the first image
  Transport newest_, leaving_;
  Transport ended_;  ///< gone at the next step: not in its own call
};

}  // namespace lode::app
