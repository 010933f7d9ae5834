#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <string>

#include <asio/io_context.hpp>

#include "client/core/session/connection.h"
#include "client/loadtest/load_client.h"
#include "client/loadtest/load_counts.h"
#include "client/net/tcp_transport.h"

namespace lode::app {

/// Replays a trace repeatedly from its own position, each request at its intended time even if earlier ones
/// are open. Latency counts from the intended time. It reconnects when its connection ends and repeats its
/// open requests.
class TraceClient final : public LoadClient {
 public:
  /// @param start    time to connect. @param phase_s  position in the trace to start from.
  /// @param names    shared by the clients of a thread.
  TraceClient(asio::io_context& io, const LoadPlan& plan, core::TimePoint start, double phase_s,
              KnownDigests& names, LoadCounts& counts);

  core::TimePoint due() const noexcept override { return due_; }
  void step(core::TimePoint now) override;
  void finish(core::TimePoint now) override;

 private:
  struct Pending {
    core::Request request;
    core::TimePoint intended;
    size_t traced = 0;  ///< index in the trace
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
  size_t first_;           ///< index of the first request in the trace
  uint64_t replayed_ = 0;  ///< number of requests due so far
  double paused_s_ = 0;    ///< sum of the pauses so far
  std::mt19937_64 random_;
  core::TimePoint due_;
  core::Connection connection_;
  std::map<uint32_t, Pending> pending_;  ///< due requests without a blob, by blob number
  bool started_ = false, was_let_in_ = false, image_seen_ = false, gone_ = false;
  std::string turned_away_;  ///< last reason until the client is let in
  uint32_t first_lod_ = 0;   ///< blob of the root's coarsest LOD
  Transport newest_, leaving_;
  Transport ended_;  ///< destroyed at the next step, not in its own callback
};

}  // namespace lode::app
