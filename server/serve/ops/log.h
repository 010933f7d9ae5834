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
  kRefused,          ///< a connection was refused; the line says why
  kUnauthorized,     ///< a token is unknown or has expired
  kProtocolMistake,  ///< a client broke a rule of the protocol
  kDamagedStore,     ///< a blob does not match its checksum, or a store file changed
  kSystem,           ///< the operating system refused a read, an accept or memory
};
constexpr size_t kLogKinds = 7;

/// Returns the kind's name in the log: "connection", "refused" and so on.
std::string_view logKindName(LogKind kind) noexcept;

/// Token bucket for each kind of line: kBurst lines at once, then kPerSecond. Not thread safe.
class LogLimit {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  static constexpr double kBurst = 50, kPerSecond = 5;

  /// Returns true if a line of this kind may be written now; otherwise counts it as left out.
  bool admit(LogKind kind, TimePoint now) noexcept;
  /// Returns how many lines of this kind were left out and resets the count, once a line of this kind may be
  /// written again. Returns 0 until then.
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

/// Longest line with its newline. A pipe takes writes of up to PIPE_BUF (4096) bytes whole or not at all.
constexpr size_t kMaxLogLineBytes = 4096;

/// Formats "2026-11-22T03:18:12.123Z refused: the message (name=value, ...)" or, as JSON, one object with the
/// keys time, kind, message and the fields' names. Replaces bytes that are not printable by '?' and ends with
/// a newline. Thread safe.
std::string logLine(bool json, std::chrono::system_clock::time_point time, LogKind kind,
                    std::string_view message, std::span<const LogField> fields);

/// Writes lines to a file, terminal, pipe or socket without blocking, even if its reader is gone or has
/// stopped reading. Leaves the descriptor's flags unchanged because other processes share them. Not thread
/// safe. The calling thread must block SIGPIPE.
class LogSink {
 public:
  /// @param descriptor  stays open and is not owned.
  explicit LogSink(int descriptor) noexcept;
  ~LogSink();
  LogSink(const LogSink&) = delete;
  LogSink& operator=(const LogSink&) = delete;

  /// @param line  at most kMaxLogLineBytes. @return true if the descriptor took all of it.
  bool write(std::string_view line) noexcept;

 private:
  bool ready() const noexcept;

  int descriptor_;
  int own_ = -1;  ///< the same pipe, opened again: O_NONBLOCK then affects this process alone
  bool is_socket_ = false;
};

/// Returns an exception's message for operators; for std::bad_alloc, whose what() is no sentence, a text of
/// our own. Valid as long as the exception.
std::string_view reasonOf(const std::exception& error) noexcept;

struct LogOptions {
  bool json = false;
  int descriptor = 2;         ///< stderr; not owned
  size_t queue_lines = 1024;  ///< lines that wait for the descriptor; a full queue drops its oldest line
  std::function<std::chrono::steady_clock::time_point()> clock = std::chrono::steady_clock::now;
};

/// The server's log. write() never blocks and never fails: a bounded queue (spdlog's) hands lines to a thread
/// that writes them without blocking and counts those that it drops. LogLimit bounds each kind of line, and a
/// line of its own says how many were left out. Thread safe.
class Log {
 public:
  explicit Log(LogOptions options = {});
  ~Log();  ///< writes the queued lines that the descriptor takes without blocking
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void write(LogKind kind, std::string_view message, std::span<const LogField> fields) noexcept;
  void write(LogKind kind, std::string_view message, std::initializer_list<LogField> fields = {}) noexcept {
    write(kind, message, std::span(fields.begin(), fields.size()));
  }
  /// Reports left-out lines of the kinds that may be written again. Call it about once a second.
  void tick() noexcept;

  uint64_t linesDropped() const noexcept;  ///< lines that neither the queue nor the descriptor took
  uint64_t linesLeftOut() const noexcept;  ///< lines over the rate limits

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode::serve
