#pragma once

#include <array>
#include <optional>
#include <random>
#include <string>

#include "client/core/session/session.h"
#include "common/error.h"

namespace lode::core {

/// Longest wait before the first retry. This limit grows by 50 % with each retry, up to kLastRetry.
constexpr std::chrono::milliseconds kFirstRetry{500};
constexpr std::chrono::seconds kLastRetry{30};  ///< longest wait before a retry
/// Longest wait before reconnecting after the server has announced its shutdown.
constexpr std::chrono::milliseconds kMoveOn{200};

/// The two sessions of a connection: the active session, and the draining session, which only completes its
/// open requests because its server is shutting down.
enum class SessionRole : uint8_t { kActive, kDraining };
inline constexpr std::array kSessionRoles{SessionRole::kActive, SessionRole::kDraining};

/// Reconnects to a server: starts a new session when the last session has ended. Waits longer after each
/// failed attempt, with jitter, so that the clients of a restarted server do not all reconnect at once. When
/// a server announces its shutdown, the old session drains its open requests while the next session starts.
/// Not thread safe.
class Connection {
 public:
  /// @param options      options of each session; awaits_model takes effect only after the model has been
  /// open once.
  /// @param jitter_seed  seed of the random waiting times.
  Connection(SessionOptions options, uint32_t jitter_seed)
      : options_(std::move(options)), random_(jitter_seed) {}

  /// Returns true if the caller should open a transport and call begin().
  bool due(TimePoint now) const noexcept { return (!session_ || is_draining_) && now >= retry_at_; }
  /// Starts a session on a new transport. The session's first bytes can be sent at once.
  /// @param known_build_id  build of the model that the client has loaded; zeros for none.
  void begin(const Digest& known_build_id, TimePoint now);
  /// Returns the session in a role; null if there is none.
  Session* session(SessionRole role = SessionRole::kActive) noexcept {
    std::optional<Session>& session = role == SessionRole::kActive ? session_ : draining_;
    return session ? &*session : nullptr;
  }
  const Session* session(SessionRole role = SessionRole::kActive) const noexcept {
    return const_cast<Connection*>(this)->session(role);
  }
  /// Returns true if requests may be sent, because there is an active session whose server is not shutting
  /// down.
  bool takesRequests() const noexcept { return session_ && !is_draining_; }

  /// Notes that the model is open, and resets the retry interval.
  void succeeded() noexcept;
  /// Ends the active session and schedules a retry. @param why  reason, worded for users.
  /// @param remedy  remedy that the text leaves to the program.
  void end(std::string why, TimePoint now, Remedy remedy = Remedy::kNone);
  /// Returns true if a retry may succeed: the error is a network error or a timeout, and either the model has
  /// been open before or SessionOptions::open_patience has not passed.
  bool survives(const Error& error, TimePoint now) const noexcept;
  /// Ends the active session after an error. @throws the error if a retry cannot help: see survives().
  void fail(const Error& error, TimePoint now);
  /// Notes that the server is shutting down. Schedules the next session soon and keeps the current session
  /// until it ends; repeated notices change nothing. If the model is not open, ends the current session at
  /// once.
  void leave(std::string why, TimePoint now, Remedy remedy = Remedy::kNone);
  /// Ends the draining session.
  void endDraining() noexcept;
  /// Ends the active session and schedules the next one: at once, or kFirstRetry after the last restart, so
  /// that a server cannot make the client reconnect in a tight loop.
  void restart(TimePoint now);

  /// Returns the reason for the missing connection; empty while there is a connection.
  const std::string& trouble() const noexcept { return trouble_; }
  /// Returns the remedy for the trouble; kNone while there is a connection.
  Remedy troubleRemedy() const noexcept { return trouble_remedy_; }
  /// Returns the number of bytes that all sessions have received.
  uint64_t receivedBytes() const noexcept;

 private:
  void drop(std::optional<Session>& session) noexcept;
  TimePoint withJitter(TimePoint now, std::chrono::milliseconds longest);

  SessionOptions options_;
  std::mt19937 random_;
  std::optional<Session> session_, draining_;
  bool is_draining_ = false;              // the server of the active session is shutting down
  std::optional<TimePoint> first_begin_;  // time of the first begin()
  std::optional<TimePoint> restarted_;    // time at which the session after the last restart() was due
  TimePoint retry_at_ = TimePoint::min();
  std::chrono::milliseconds longest_wait_ = kFirstRetry;  // longest wait before the next attempt
  bool ever_open_ = false;
  uint64_t received_before_bytes_ = 0;
  std::string trouble_;
  Remedy trouble_remedy_ = Remedy::kNone;
};

}  // namespace lode::core
