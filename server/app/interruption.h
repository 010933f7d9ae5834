#pragma once

#include <array>
#include <csignal>
#include <string>
#include <thread>

#include <semaphore.h>

namespace lode::app {

/// Records SIGINT, SIGTERM and SIGHUP while the object exists, so that the running work can end at its next
/// check() and remove its temporary files. If the work does not end within half a second, a thread removes
/// all Unfinished files and ends the process by the signal. Ignored signals stay ignored. Only one object can
/// exist at a time.
class Interruption {
 public:
  /// @param message  message of the error that check() throws.
  /// @param hint  text after the message if the thread ends the process before check() throws; may be empty.
  Interruption(const char* message, const char* hint);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// Checks for a signal. @throws Error kIo if a signal was received.
  void check() const;
  /// If a signal was received, prints the message and ends the process by the same signal, as the sender
  /// expects. Call this function after the cleanup.
  void endProcessIfReceived(const char* message) const;

 private:
  void endAfterGrace();

  const char* message_;
  const std::string forced_message_;
  std::array<struct sigaction, 3> before_{};
  sem_t ended_{};  ///< posted by the destructor
  std::jthread watcher_;
};

}  // namespace lode::app
