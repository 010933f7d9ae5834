#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace lode {

enum class ErrorCode {
  kUsage,     ///< wrong use of a program or function: exit status 2
  kInput,     ///< a user's file is damaged or of the wrong kind
  kIo,        ///< the operating system refused to open, read, write or rename, or the disk is full
  kFormat,    ///< a store, page, payload or frame is damaged
  kLimit,     ///< a length or count exceeds a named limit
  kNetwork,   ///< connecting, sending or receiving failed, or the peer closed the connection
  kProtocol,  ///< the peer broke the protocol
  kTimeout,   ///< a deadline passed
  kInternal,  ///< a bug in Lodestream
};

/// Names a remedy that users apply through their program. Libraries know neither command lines nor the
/// embedding API, so they set the code, and programs put it in words.
enum class Remedy : uint8_t {
  kNone,                ///< nothing to add: the message itself says what to do
  kModel,               ///< name a model that the server has
  kToken,               ///< give a valid token
  kCertificate,         ///< use the host name of the certificate, and trust its authority
  kAuthorities,         ///< give certificates in PEM
  kCacheFolder,         ///< choose another cache folder
  kForeignCacheFolder,  ///< remove the file or folder at the cache's path, or choose another cache folder
};
constexpr Remedy kLastRemedy = Remedy::kForeignCacheFolder;  ///< last constant of Remedy

/// The exception type of Lodestream. The message is one line that says what failed, where (file, byte, line,
/// address) and what to do. If `remedy` is not kNone, the message leaves the last part to the program, which
/// prints its words for the remedy after the message.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message, Remedy remedy = Remedy::kNone)
      : std::runtime_error(message), code_(code), remedy_(remedy) {}
  ErrorCode code() const noexcept { return code_; }
  Remedy remedy() const noexcept { return remedy_; }

 private:
  ErrorCode code_;
  Remedy remedy_;
};

/// Message for std::bad_alloc.
constexpr const char* kOutOfMemory =
    "out of memory: raise the limit of the program (ulimit -v), or give it a smaller memory budget";

}  // namespace lode
