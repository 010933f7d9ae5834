#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <string>

#include <asio/io_context.hpp>

#include "client/core/session/connection.h"
#include "client/loadtest/known_digests.h"
#include "client/loadtest/load_client.h"
#include "client/loadtest/load_counts.h"
#include "client/loadtest/load_plan.h"
#include "client/net/tcp_transport.h"

namespace lode::app {

/// Replays a trace over and over from a place of its own in it, each request at its intended time whether or
/// not those before are there. What is late counts from that time. When its connection ends it comes again,
/// as any client does, and requests again what it has not got.
class TraceClient final : public LoadClient {
 public:
  /// @param start    when it connects. @param phase_s  where in the trace it begins.
  /// @param names    of the clients of its thread.
  TraceClient(asio::io_context& io, const LoadPlan& plan, core::TimePoint start, double phase_s,
              KnownDigests& names, LoadCounts& counts);

  core::TimePoint due() const noexcept override { return due_; }
  void step(core::TimePoint now) override;
  void finish(core::TimePoint now) override;

 private:
  struct Pending {
    core::Request request;
    core::TimePoint intended;
    size_t traced = 0;  ///< its place in the trace
  };

  using Transport = std::unique_ptr<net::TcpTransport>;

  core::SessionOptions sessionOptions();
  Transport& transport(core::SessionRole role) noexcept {
    return role == core::SessionRole::kActive ? newest_ : leaving_;
  }
  template <typename Action>
  void guarded(const Action& action);
  template <typename Action>
  void onSession(core::SessionRole role, core::TimePoint now, const Action& action);
  void connect(core::TimePoint now);
  void send();
  void receive();
  void handle(const core::SessionEvent& event, core::Session& session, core::TimePoint now);
  void arrived(const core::BlobArrived& blob, core::Session& session, core::TimePoint now);
  void addDueRequests(core::TimePoint now);
  void sendRequests();
  void scheduleNext(core::TimePoint now);
  core::TimePoint nextIntended() const noexcept;
  void goOn();

  asio::io_context& io_;
  const LoadPlan& plan_;
  KnownDigests& names_;
  LoadCounts& counts_;
  const core::TimePoint start_;
  size_t first_;           ///< place in the trace at which it begins
  uint64_t replayed_ = 0;  ///< requests that were due so far
  double paused_s_ = 0;    ///< between the rounds so far
  std::mt19937_64 random_;
  core::TimePoint due_;
  core::Connection connection_;
  std::map<uint32_t, Pending> pending_;  ///< by blob number
  bool started_ = false, was_let_in_ = false, image_seen_ = false, gone_ = false;
  std::string turned_away_;  ///< why, the last time, until it is let in
  uint32_t first_lod_ = 0;   ///< number of the blob that makes the first image
  Transport newest_, leaving_;
  Transport ended_;  ///< gone at the next step: not in its own call
};

}  // namespace lode::app
