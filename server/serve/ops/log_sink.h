#pragma once

#include <cstddef>
#include <string_view>

namespace lode::serve {

/// Writes lines to a descriptor that may be a file, a terminal, a pipe or a socket, and whose reader may be
/// gone or stand still. Never waits, whether or not the descriptor is non-blocking, and leaves its flags as
/// they are, which others share. Not thread safe. The thread that calls it must not take SIGPIPE.
class LogSink {
 public:
  /// @param descriptor  not owned.
  explicit LogSink(int descriptor) noexcept;
  ~LogSink();
  LogSink(const LogSink&) = delete;
  LogSink& operator=(const LogSink&) = delete;

  /// @param line  at most kMaxLogLineBytes. @return whether the descriptor took it, whole.
  bool write(std::string_view line) noexcept;

 private:
  bool ready() const noexcept;

  int descriptor_;
  int own_ = -1;  ///< the same pipe, opened again, so that not to wait is ours alone
  bool is_socket_ = false;
};

}  // namespace lode::serve
