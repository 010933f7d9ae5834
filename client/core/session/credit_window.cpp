#include "client/core/session/credit_window.h"

#include <algorithm>

#include "proto/limits.h"

namespace lode::core {
namespace {

constexpr double kMuchFaster = 1.25;

}  // namespace

void CreditWindow::measureTrip(std::chrono::nanoseconds trip) noexcept {
  round_trip_ = round_trip_ ? std::min(*round_trip_, trip) : trip;
}

std::chrono::nanoseconds CreditWindow::sampleTime() const noexcept {
  return std::max<std::chrono::nanoseconds>(kShortestSample, round_trip_.value_or(kShortestSample));
}

void CreditWindow::receive(uint64_t bytes, TimePoint now) {
  if (!sample_begin_) {  // the time at which these bytes began to arrive is unknown
    sample_begin_ = now;
    sample_bytes_ = 0;
    return;
  }
  sample_bytes_ += bytes;
  const std::chrono::duration<double> passed = now - *sample_begin_;
  if (passed < sampleTime()) return;
  const double rate = static_cast<double>(sample_bytes_) / passed.count();
  growing_ = rate > kMuchFaster * bytesPerSecond();
  rates_.push_back(rate);
  if (rates_.size() > kRateSamples) rates_.pop_front();
  sample_begin_ = now;
  sample_bytes_ = 0;
}

double CreditWindow::bytesPerSecond() const noexcept {
  return rates_.empty() ? 0 : *std::max_element(rates_.begin(), rates_.end());
}

uint64_t CreditWindow::bytes() const noexcept {
  const std::chrono::duration<double> trip =
      std::max<std::chrono::nanoseconds>(kShortestTrip, round_trip_.value_or(kShortestTrip));
  const double wanted = bytesPerSecond() * trip.count() * (growing_ ? kGrowthGain : kWindowGain);
  return static_cast<uint64_t>(std::clamp(wanted, static_cast<double>(proto::kInitialWindowBytes),
                                          static_cast<double>(kMaxWindowBytes)));
}

}  // namespace lode::core
