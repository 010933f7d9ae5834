#include "client/core/link.h"

#include <algorithm>
#include <utility>

namespace lode::core {
namespace {

constexpr unsigned kMostDoublings = 6;  // reaches kLastRetry

}  // namespace

void Link::begin(const BlobName& known_build_id, TimePoint now) {
  options_.known_build_id = known_build_id;
  session_.emplace(options_, now);
}

void Link::succeeded() noexcept {
  failures_ = 0;
  ever_open_ = true;
  trouble_.clear();
}

void Link::drop() noexcept {
  if (session_) received_before_bytes_ += session_->receivedBytes();
  session_.reset();
}

void Link::end(std::string why, TimePoint now) {
  drop();
  using Milliseconds = std::chrono::milliseconds;
  const Milliseconds longest =
      std::min<Milliseconds>(kFirstRetry * (1u << std::min(failures_, kMostDoublings)), kLastRetry);
  ++failures_;
  retry_at_ = now + Milliseconds(std::uniform_int_distribution<int64_t>(longest.count() / 2,
                                                                        longest.count())(random_));
  trouble_ = std::move(why);
}

void Link::fail(const Error& error, TimePoint now) {
  const bool may_pass = error.code() == ErrorCode::kNetwork || error.code() == ErrorCode::kTimeout;
  if (!ever_open_ || !may_pass) throw error;
  end(error.what(), now);
}

void Link::restart(TimePoint now) {
  drop();
  retry_at_ = now;
}

uint64_t Link::receivedBytes() const noexcept {
  return received_before_bytes_ + (session_ ? session_->receivedBytes() : 0);
}

}  // namespace lode::core
