#pragma once

#include <array>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <asio/io_context.hpp>

#include "client/core/engine.h"
#include "client/loadtest/load_client.h"
#include "client/loadtest/load_counts.h"
#include "client/loadtest/request_watch.h"
#include "client/net/tcp_transport.h"
#include "common/error.h"

namespace lode::app {

/// Simulates a viewer, except that nothing is drawn: follows a camera path, refines, decodes and reconnects.
/// The camera never waits for data.
class FullClient final : public LoadClient {
 public:
  /// @param start  time to connect.
  /// @param seed   seed of the client's path and pauses.
  /// @param names  verified digests, which all clients of a thread share.
  FullClient(asio::io_context& io, const LoadPlan& plan, core::TimePoint start, uint64_t seed,
             KnownDigests& names, LoadCounts& counts);

  core::TimePoint due() const noexcept override { return due_; }
  void step(core::TimePoint now) override;
  void finish(core::TimePoint now) override;

 private:
  class End;
  using Transports = std::array<std::unique_ptr<net::TcpTransport>, 2>;  // indexed by core::SessionRole

  core::EngineOptions engineOptions(uint64_t seed);
  bool noteBlob(const BlobRef& blob, std::span<const std::byte> bytes);
  void noteLatency(const RequestClock::Request& request, core::TimePoint now);
  void noteBroken(core::SessionRole role, const Error& why, bool is_last);
  void lose(core::SessionRole role);
  void noteRefused(const BlobRef& blob, const std::string& why);
  template <typename Action>
  void guarded(const Action& action);
  void keepConnected(core::TimePoint now);
  void receive();
  void look(core::TimePoint now);
  core::CameraKey camera(core::TimePoint now);
  void work(core::TimePoint now);
  void decode(const core::DecodeJob& job);
  void note(core::TimePoint now);

  asio::io_context& io_;
  const LoadPlan& plan_;
  const uint64_t seed_;
  KnownDigests& names_;
  LoadCounts& counts_;
  const core::TimePoint start_;
  core::TimePoint due_;
  core::TimePoint noted_until_;  ///< time until which note() has updated counts_
  uint64_t frames_ = 0;
  std::mt19937_64 random_;
  std::array<RequestClock, 2> clocks_;  ///< indexed by core::SessionRole
  RequestClock::Requests lost_;  ///< requests of broken connections that the client has not repeated yet
  core::Engine engine_;
  core::CameraPath path_;            ///< path of the camera; has no keys until the model is known
  core::TimePoint round_begin_;      ///< start of the current round of the path
  double pause_s_ = 0;               ///< pause after the current round
  uint64_t received_bytes_ = 0;      ///< received bytes that counts_ already includes
  core::ServerLeaving turned_away_;  ///< last reason why the server turned the client away
  bool started_ = false, image_seen_ = false, converged_ = false, gone_ = false;
  Transports transports_;
  /// Transports of ended connections. The next step() destroys them, because a transport must not be
  /// destroyed in its own callback.
  std::vector<std::unique_ptr<net::TcpTransport>> ended_;
};

}  // namespace lode::app
