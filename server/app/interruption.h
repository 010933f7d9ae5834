#pragma once

#include <array>
#include <csignal>

namespace lode::app {

/// Records SIGINT, SIGTERM and SIGHUP while the object exists. Meanwhile these signals do not end the
/// process, so that the running work can remove its temporary files. Ignored signals stay ignored. Only one
/// object can exist at a time.
class Interruption {
 public:
  /// @param message  message of the error that check() throws.
  explicit Interruption(const char* message);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// Checks for a signal. @throws Error kIo if a signal was received.
  void check() const;
  /// If a signal was received, prints the message and ends the process by the same signal, as the sender
  /// expects. Call this function after the cleanup.
  void endProcessIfReceived(const char* message) const;

 private:
  const char* message_;
  std::array<struct sigaction, 3> before_{};
};

}  // namespace lode::app
