#include "client/core/session/connection.h"

#include <algorithm>
#include <utility>

namespace lode::core {

void Connection::begin(const Digest& known_build_id, TimePoint now) {
  if (!first_begin_) first_begin_ = now;
  options_.known_build_id = known_build_id;
  if (session_) {
    drop(draining_);
    draining_ = std::exchange(session_, std::nullopt);
  }
  is_draining_ = false;
  SessionOptions options = options_;
  options.awaits_model = options_.awaits_model && ever_open_;
  session_.emplace(std::move(options), now);
}

void Connection::succeeded() noexcept {
  longest_wait_ = kFirstRetry;
  ever_open_ = true;
  trouble_.clear();
  trouble_remedy_ = Remedy::kNone;
}

void Connection::drop(std::optional<Session>& session) noexcept {
  if (session) received_before_bytes_ += session->receivedBytes();
  session.reset();
}

/// Returns `now` plus a random wait from longest / 2 to `longest`.
TimePoint Connection::withJitter(TimePoint now, std::chrono::milliseconds longest) {
  std::uniform_int_distribution<int64_t> wait_ms(longest.count() / 2, longest.count());
  return now + std::chrono::milliseconds(wait_ms(random_));
}

void Connection::end(std::string why, TimePoint now, Remedy remedy) {
  drop(session_);
  is_draining_ = false;
  retry_at_ = withJitter(now, longest_wait_);
  longest_wait_ = std::min<std::chrono::milliseconds>(longest_wait_ * 3 / 2, kLastRetry);
  trouble_ = std::move(why);
  trouble_remedy_ = remedy;
}

void Connection::leave(std::string why, TimePoint now, Remedy remedy) {
  if (is_draining_) return;
  if (!session_->opened()) return end(std::move(why), now, remedy);
  is_draining_ = true;
  retry_at_ = withJitter(now, kMoveOn);
}

void Connection::endDraining() noexcept { drop(draining_); }

bool Connection::survives(const Error& error, TimePoint now) const noexcept {
  const bool may_pass = error.code() == ErrorCode::kNetwork || error.code() == ErrorCode::kTimeout;
  const bool is_patient = first_begin_ && now - *first_begin_ < options_.open_patience;
  return may_pass && (ever_open_ || is_patient);
}

void Connection::fail(const Error& error, TimePoint now) {
  if (!survives(error, now)) throw error;
  end(error.what(), now, error.remedy());
}

void Connection::restart(TimePoint now) {
  drop(session_);
  is_draining_ = false;
  retry_at_ = restarted_ ? std::max(now, *restarted_ + kFirstRetry) : now;
  restarted_ = retry_at_;
}

uint64_t Connection::receivedBytes() const noexcept {
  return received_before_bytes_ + (session_ ? session_->receivedBytes() : 0) +
         (draining_ ? draining_->receivedBytes() : 0);
}

}  // namespace lode::core
