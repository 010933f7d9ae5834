#pragma once

#include <array>
#include <csignal>

namespace lode::app {

/// While it lives, SIGINT, SIGTERM and SIGHUP, but for those that are ignored, do not end the process, but
/// are told, so that work can end with its temporary files removed. One at a time.
class Interruption {
 public:
  /// @param message  of the error when a signal has come.
  explicit Interruption(const char* message);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// @throws Error kIo if a signal has come.
  void check() const;
  /// Once all that was under way has been put in order: if a signal has come, ends the process by it, as
  /// whoever sent it expects. @param message  that is said before.
  void endProcessIfOneCame(const char* message) const;

 private:
  const char* message_;
  std::array<struct sigaction, 3> before_{};
};

}  // namespace lode::app
