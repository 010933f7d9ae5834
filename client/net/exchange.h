#pragma once

#include <cstddef>
#include <span>

#include "client/core/engine.h"
#include "client/net/tcp_transport.h"
#include "proto/messages.h"

namespace lode::net {

/// Largest number of reads and writes in one call of exchange().
constexpr size_t kMaxExchangeRounds = 16;
/// Number of received bytes at which a call of exchange() returns. The limit is for floods of small frames,
/// which cost most per byte.
constexpr size_t kMaxExchangeBytes = kMaxReceivedBytes;

/// Sends the frames that a client's end of the protocol has queued. If the transport has no room, the frames
/// stay in `end`. @param end  an object with takeOutgoing().
template <typename Transport, typename End>
void sendOutgoing(Transport& transport, End& end) {
  if (transport.hasRoom()) transport.send(end.takeOutgoing());
}

/// Passes received bytes to a client's end of the protocol. While `end` takes no input because its answers
/// are unsent, sends the answers first, and stops if the transport has no room. A server that sends without
/// reading therefore cannot fill a queue. One call does limited work, so that the caller can check deadlines
/// even during a flood of frames.
/// @param transport  a TcpTransport, or an object with its functions.
/// @param end  an object with connected(), takesInput(), takeOutgoing() and receive(bytes); receive() also
/// handles the events.
/// @return true if the caller should call again at once. If not, the transport wakes its owner when there is
/// more to do.
/// @throws Error as TcpTransport and `end` do.
template <typename Transport, typename End>
bool exchange(Transport& transport, End& end) {
  if (end.connected()) sendOutgoing(transport, end);
  size_t received_bytes = 0;
  for (size_t round = 0; round < kMaxExchangeRounds && received_bytes < kMaxExchangeBytes && end.connected();
       ++round) {
    if (end.takesInput()) {
      const proto::Bytes bytes = transport.takeReceived();
      if (bytes.empty()) return false;
      received_bytes += bytes.size();
      end.receive(bytes);
    } else {
      if (!transport.hasRoom()) return false;
      transport.send(end.takeOutgoing());
      end.receive(proto::Bytes());
    }
  }
  return end.connected();
}

/// Adapts one connection of an engine to exchange().
class EngineEnd {
 public:
  EngineEnd(core::Engine& engine, core::SessionRole role, core::TimePoint now) noexcept
      : engine_(engine), role_(role), now_(now) {}

  bool connected() const noexcept { return engine_.connected(role_); }
  bool takesInput() const noexcept { return engine_.takesInput(role_); }
  proto::Bytes takeOutgoing() { return engine_.takeOutgoing(role_); }
  void receive(std::span<const std::byte> bytes) { engine_.receive(bytes, now_, role_); }

 private:
  core::Engine& engine_;
  const core::SessionRole role_;
  const core::TimePoint now_;
};

}  // namespace lode::net
