#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace lode::serve {

/// A connection of any protocol, as its thread manages it. Not thread safe.
class ClientConnection {
 public:
  virtual ~ClientConnection() = default;

  /// Serves the requests that have arrived, then ends. @param reason  reason for the client.
  virtual void drain(const std::string& reason) = 0;
  /// Handles a change of the models and tokens.
  virtual void servedSetChanged() = 0;
  /// Closes the connection if a deadline has passed.
  virtual void sweep(std::chrono::steady_clock::time_point now) = 0;
  /// Ends the connection because it uses much of the memory budget.
  virtual void endForMemory() = 0;
  virtual uint64_t heldBytes() const noexcept = 0;
};

}  // namespace lode::serve
