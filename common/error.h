#pragma once

#include <stdexcept>
#include <string>

namespace lode {

enum class ErrorCode {
  kUsage,     ///< wrong use of a program or function: exit status 2
  kInput,     ///< a file of the user is damaged or of the wrong kind
  kIo,        ///< the operating system refused to open, read, write or rename, or the disk is full
  kFormat,    ///< a store, page, payload or frame is damaged
  kLimit,     ///< a length or count exceeds a named limit
  kNetwork,   ///< connecting, sending or receiving failed, or the peer closed the connection
  kProtocol,  ///< the peer broke the protocol
  kTimeout,   ///< a deadline passed
  kInternal,  ///< a bug in Lodestream
};

/// The exception type of Lodestream. The message is one line that says what failed, where (file, byte, line,
/// address) and what to do. Programs print it unchanged.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

/// Message for std::bad_alloc.
constexpr const char* kOutOfMemory =
    "out of memory: raise the limit of the program (ulimit -v), or give it a smaller memory budget";

}  // namespace lode
