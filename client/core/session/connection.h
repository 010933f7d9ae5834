#pragma once

#include <array>
#include <optional>
#include <random>
#include <string>

#include "client/core/session/session.h"
#include "common/error.h"

namespace lode::core {

constexpr std::chrono::milliseconds kFirstRetry{500};  ///< longest wait before the first new try
constexpr std::chrono::milliseconds kMoveOn{200};      ///< longest wait where a server is going away
constexpr std::chrono::seconds kLastRetry{30};         ///< and before any; half more each time in between

/// Which of a connection's connections: the newest, or the one before whose server is going away.
enum class Line : uint8_t { kActive, kDraining };
inline constexpr std::array kLines{Line::kActive, Line::kDraining};

/// A session with a server that is begun anew when its connection ends. Says when, and waits longer after
/// each try that fails, with jitter, so that the clients of a server that restarts do not come all at once.
/// A session whose server is going away stays beside the next one, for what it was requested. Not thread
/// safe.
class Connection {
 public:
  /// @param options      awaits_model of them: once it was open.
  /// @param jitter_seed  of the waiting times.
  Connection(SessionOptions options, uint32_t jitter_seed)
      : options_(std::move(options)), random_(jitter_seed) {}

  /// A connection is to be made now: make a transport, then begin().
  bool due(TimePoint now) const noexcept { return (!session_ || is_leaving_) && now >= retry_at_; }
  /// There is a transport: a session begins, whose first bytes can be taken.
  /// @param known_build_id  of the model as the client has it; zeros for none.
  void begin(const Digest& known_build_id, TimePoint now);
  /// Null while there is no such connection.
  Session* session(Line line = Line::kActive) noexcept {
    std::optional<Session>& session = line == Line::kActive ? session_ : leaving_;
    return session ? &*session : nullptr;
  }
  const Session* session(Line line = Line::kActive) const noexcept {
    return const_cast<Connection*>(this)->session(line);
  }
  /// New requests may be sent: there is a newest session, and its server stays.
  bool takesRequests() const noexcept { return session_ && !is_leaving_; }

  /// The model is open: the next failure is the first again.
  void succeeded() noexcept;
  /// The session has ended; another is due after a while. @param why  for people.
  void end(std::string why, TimePoint now);
  /// Another try may go better. Not where the server was never reached, nor with a mistake that is not the
  /// network's.
  bool survives(const Error& error) const noexcept;
  /// The connection failed. @throws the error where a new try would fail too: see survives().
  void fail(const Error& error, TimePoint now);
  /// The server is going away: another connection is due soon, and the session stays until it ends.
  void leave(std::string why, TimePoint now);
  /// The session before has ended.
  void endDraining() noexcept;
  /// The session has ended; another is due at once.
  void restart(TimePoint now);

  /// Why there is no connection; empty while there is one that works.
  const std::string& trouble() const noexcept { return trouble_; }
  /// By all sessions.
  uint64_t receivedBytes() const noexcept;

 private:
  void drop(std::optional<Session>& session) noexcept;
  TimePoint someTimeAfter(TimePoint now, std::chrono::milliseconds longest);

  SessionOptions options_;
  std::mt19937 random_;
  std::optional<Session> session_, leaving_;
  bool is_leaving_ = false;  // the newest session
  TimePoint retry_at_ = TimePoint::min();
  std::chrono::milliseconds longest_wait_ = kFirstRetry;  // before the next try
  bool ever_open_ = false;
  uint64_t received_before_bytes_ = 0;
  std::string trouble_;
};

}  // namespace lode::core
