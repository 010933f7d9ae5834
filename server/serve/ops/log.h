#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string_view>

#include "server/serve/ops/log_line.h"

namespace lode::serve {

/// What an exception says, in an operator's words: std::bad_alloc's own are none. Valid as long as it is.
std::string_view reasonOf(const std::exception& error) noexcept;

struct LogOptions {
  bool json = false;
  int descriptor = 2;         ///< not owned: stderr
  size_t queue_lines = 1024;  ///< that wait for the descriptor; beyond them the oldest are dropped
  std::function<std::chrono::steady_clock::time_point()> clock = std::chrono::steady_clock::now;
};

/// The server's log. Whoever writes a line never waits and never fails: lines go through a bounded queue to a
/// thread of the log's own (spdlog's), which writes what the descriptor takes at once and drops the rest,
/// counted; a reader that is gone or stands still costs lines and nothing else. Each kind of line is limited
/// (LogLimit); what was left out is said in a line of its own. Thread safe.
class Log {
 public:
  explicit Log(LogOptions options = {});
  ~Log();  ///< writes what waits, unless the descriptor takes nothing
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void write(LogKind kind, std::string_view message, std::span<const LogField> fields) noexcept;
  void write(LogKind kind, std::string_view message, std::initializer_list<LogField> fields = {}) noexcept {
    write(kind, message, std::span(fields.begin(), fields.size()));
  }
  /// Says how many lines were left out, of the kinds that may be written again; call it about every second.
  void tick() noexcept;

  uint64_t linesDropped() const noexcept;  ///< that the descriptor or the queue did not take
  uint64_t linesLeftOut() const noexcept;  ///< that the limits held back

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode::serve
