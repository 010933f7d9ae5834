#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>

namespace lode::serve {

/// Subject of a log line. Each kind has its own rate limit.
enum class LogKind : uint8_t {
  kServer,           ///< start, stop, reload
  kConnectionEnd,    ///< one line for each connection
  kRefused,          ///< a connection was refused; the line states the reason
  kUnauthorized,     ///< a token is unknown or has expired
  kProtocolMistake,  ///< a client broke a rule of the protocol
  kDamagedStore,     ///< a blob does not match its checksum, or a store file changed in place
  kUnreadableStore,  ///< the operating system cannot read a store, or can read it again
  kSystem,           ///< the operating system refused a read, an accept or memory
};
constexpr size_t kLogKinds = 8;

/// Returns the kind's name in the log: "connection", "refused" and so on.
std::string_view logKindName(LogKind kind) noexcept;

/// Limits each kind of line with a token bucket: kBurst lines at once, then kPerSecond lines per second.
/// Lines above the limit are left out. Not thread safe.
class LogLimit {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  static constexpr double kBurst = 50, kPerSecond = 5;

  /// Returns true if a line of this kind can be written now. Otherwise counts the line as left out.
  bool admit(LogKind kind, TimePoint now) noexcept;
  /// If a line of this kind can be written again, returns and resets the number of its left-out lines.
  /// Otherwise returns 0.
  uint64_t takeLeftOut(LogKind kind, TimePoint now) noexcept;

 private:
  struct Bucket {
    double lines = kBurst;
    TimePoint filled{};
    uint64_t left_out = 0;
  };
  Bucket& fill(LogKind kind, TimePoint now) noexcept;
  std::array<Bucket, kLogKinds> buckets_;
};

/// A named value that follows a line's message.
struct LogField {
  std::string_view name;
  std::variant<uint64_t, double, std::string_view> value;
};

/// Limit of a line's length, with the newline. A pipe accepts a write of up to PIPE_BUF (4096) bytes either
/// completely or not at all.
constexpr size_t kMaxLogLineBytes = 4096;

/// Formats a line with its newline: "2026-11-22T03:18:12.123Z refused: the message (name=value, ...)", or, as
/// JSON, one object with the keys time, kind, message and the names of the fields. Replaces unprintable bytes
/// with '?'. Thread safe.
std::string logLine(bool json, std::chrono::system_clock::time_point time, LogKind kind,
                    std::string_view message, std::span<const LogField> fields);

/// Writes lines to a file, terminal, pipe or socket. Never blocks, even if the reader of a pipe or socket is
/// gone or has stopped reading. Leaves the descriptor's flags unchanged because other processes share them.
/// Not thread safe. The calling thread must block SIGPIPE.
class LogSink {
 public:
  /// @param descriptor  open descriptor that the caller owns.
  explicit LogSink(int descriptor) noexcept;
  ~LogSink();
  LogSink(const LogSink&) = delete;
  LogSink& operator=(const LogSink&) = delete;

  /// Writes a line of at most kMaxLogLineBytes. @return true if the whole line was written.
  bool write(std::string_view line) noexcept;

 private:
  bool ready() const noexcept;

  int descriptor_;
  /// Second descriptor of the pipe, opened again so that O_NONBLOCK affects only this process.
  int own_ = -1;
  bool is_socket_ = false;
};

/// Returns an exception's message for operators. Replaces the message of std::bad_alloc, which is not a
/// sentence, with a readable one. The returned text is valid as long as the exception.
std::string_view reasonOf(const std::exception& error) noexcept;

struct LogOptions {
  bool json = false;
  int descriptor = 2;  ///< descriptor to which the log writes; owned by the caller; stderr by default
  /// Largest number of lines that wait for the descriptor; a full queue drops its oldest line.
  size_t queue_lines = 1024;
  std::function<std::chrono::steady_clock::time_point()> clock = std::chrono::steady_clock::now;
};

/// The server's log. write() never blocks and never fails. write() adds the line to a bounded queue of
/// spdlog. A thread writes the queued lines without blocking, and counts dropped lines. LogLimit limits each
/// kind of line; a separate line reports the number of lines left out. Thread safe.
class Log {
 public:
  explicit Log(LogOptions options = {});
  ~Log();  ///< writes queued lines as far as the descriptor accepts them without blocking
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void write(LogKind kind, std::string_view message, std::span<const LogField> fields) noexcept;
  void write(LogKind kind, std::string_view message, std::initializer_list<LogField> fields = {}) noexcept {
    write(kind, message, std::span(fields.begin(), fields.size()));
  }
  /// Writes the number of left-out lines for each kind of line whose limit allows lines again. Call tick()
  /// about once a second.
  void tick() noexcept;

  /// Number of lines that did not fit in the queue or that the descriptor did not accept.
  uint64_t linesDropped() const noexcept;
  uint64_t linesLeftOut() const noexcept;  ///< number of lines that exceeded the limits of LogLimit

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode::serve
