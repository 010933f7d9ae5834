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

/// Replays a trace again and again, starting at a position of its own. Sends each request at the intended
/// time, even while earlier requests are open. A latency is measured from the intended time. If the
/// connection ends, the client reconnects and repeats the open requests.
class TraceClient final : public LoadClient {
 public:
  /// @param start    time to connect.
  /// @param phase_s  position in the trace at which the replay starts.
  /// @param names    verified digests, which all clients of a thread share.
  TraceClient(asio::io_context& io, const LoadPlan& plan, core::TimePoint start, double phase_s,
              KnownDigests& names, LoadCounts& counts);

  core::TimePoint due() const noexcept override { return due_; }
  void step(core::TimePoint now) override;
  void finish(core::TimePoint now) override;

 private:
  struct Pending {
    core::Request request;
    core::TimePoint intended;
    size_t traced = 0;  ///< index of the request in the trace
  };

  class End;
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
  size_t first_;           ///< index in the trace of the first request that this client replays
  uint64_t replayed_ = 0;  ///< number of requests that have become due
  double paused_s_ = 0;    ///< sum of the pauses so far
  std::mt19937_64 random_;
  core::TimePoint due_;
  core::Connection connection_;
  std::map<uint32_t, Pending> pending_;  ///< due requests whose blob has not arrived, by blob number
  bool requests_wait_ = false;  ///< the session has not taken the requests of the last sendRequests()
  bool started_ = false, was_let_in_ = false, image_seen_ = false, gone_ = false;
  /// Last reason why the server turned the client away; empty once the client is let in.
  core::ServerLeaving turned_away_;
  uint32_t first_lod_ = 0;  ///< blob of the root's coarsest LOD
  Transport newest_, leaving_;
  /// Transport of an ended connection, destroyed in the next step(), because a transport must not be
  /// destroyed in its own callback.
  Transport ended_;
};

}  // namespace lode::app
