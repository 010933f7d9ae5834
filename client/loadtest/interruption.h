#pragma once

#include <array>
#include <csignal>

namespace lode::app {

/// While it lives, the first SIGINT or SIGTERM does not end the process, but is told, so that work can end
/// with what it has; the second ends it as ever. One at a time.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// The signal that has come; 0: none. Any thread may ask.
  static int signal() noexcept;

 private:
  std::array<struct sigaction, 2> before_{};
};

}  // namespace lode::app
