#include "server/serve/net/wrong_tokens.h"

#include <algorithm>
#include <utility>

namespace lode::serve {

WrongTokens::Wait::Wait(Wait&& other) noexcept
    : of_(std::exchange(other.of_, nullptr)), address_(other.address_), until_(other.until_) {}

WrongTokens::Wait::~Wait() {
  if (of_ != nullptr) of_->leave(address_);
}

WrongTokens::Clock::duration WrongTokens::delayOf(const Record& record) const noexcept {
  Clock::duration delay = first_delay_;
  for (uint32_t i = 1; i < record.wrong && delay < kLongestDelay; ++i) delay *= 2;
  return std::min<Clock::duration>(delay, kLongestDelay);
}

bool WrongTokens::blocks(uint64_t address, Clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  const auto found = records_.find(address);
  if (found == records_.end()) return false;
  const Record& record = found->second;
  return record.waiting >= kMostWaitingPerAddress ||
         (waiting_ >= kMostWaiting && now < record.last + delayOf(record));
}

std::optional<WrongTokens::Wait> WrongTokens::add(uint64_t address, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  if (!records_.contains(address)) makeRoom(now);
  Record& record = records_[address];
  if (record.wrong > 0 && now - record.last > kForget) record.wrong = 0;
  ++record.wrong;
  record.last = now;
  if (waiting_ >= kMostWaiting || record.waiting >= kMostWaitingPerAddress) return {};
  ++record.waiting;
  ++waiting_;
  return Wait(*this, address, now + delayOf(record));
}

size_t WrongTokens::waiting() const {
  const std::lock_guard lock(mutex_);
  return waiting_;
}

size_t WrongTokens::addresses() const {
  const std::lock_guard lock(mutex_);
  return records_.size();
}

void WrongTokens::leave(uint64_t address) noexcept {
  const std::lock_guard lock(mutex_);
  --waiting_;
  --records_.find(address)->second.waiting;  // an address with waiting answers is never removed
}

/// If the table is full, removes all addresses that have sent no wrong token for kForget or, if there are
/// none, the address whose last wrong token is oldest. Keeps addresses with waiting answers.
void WrongTokens::makeRoom(Clock::time_point now) {
  if (records_.size() < kMostAddresses) return;
  std::erase_if(records_, [now](const auto& entry) {
    return entry.second.waiting == 0 && now - entry.second.last > kForget;
  });
  if (records_.size() < kMostAddresses) return;
  const auto oldest = std::ranges::min_element(
      records_, {}, [](const auto& entry) { return std::pair(entry.second.waiting > 0, entry.second.last); });
  records_.erase(oldest);  // has no waiting answer, because kMostWaiting is less than kMostAddresses
}

}  // namespace lode::serve
