#pragma once

#include <stdexcept>
#include <string>

namespace lode {

enum class ErrorCode {
  kUsage,     ///< the caller asked for something that cannot be: exit status 2
  kInput,     ///< a file that the user gave is damaged or not what was expected
  kIo,        ///< the operating system refused: open, read, write, rename, disk full
  kFormat,    ///< a store, page, payload or frame that does not hold what it must
  kLimit,     ///< a length or count above a named limit
  kNetwork,   ///< connect, send or receive failed, or the peer went away
  kProtocol,  ///< the peer said something that the protocol does not allow
  kTimeout,   ///< a deadline passed
  kInternal,  ///< our own mistake
};

/// The one exception of Lodestream. The message is one line that says what failed, where (file, byte, line,
/// address) and what to do; programs print it as it is.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

/// What is said where the system gives no memory.
constexpr const char* kOutOfMemory =
    "out of memory: let the program have more (ulimit -v), or give it a smaller memory budget";

}  // namespace lode
