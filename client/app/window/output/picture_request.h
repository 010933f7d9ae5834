#pragma once

#include <chrono>
#include <optional>

namespace lode::app {

/// A picture that a key has asked for: it waits for the window to come to rest, so that it has the detail of
/// a camera at rest and the panel's last word, but no longer than kLongestWait, while models stream or fade.
class PictureRequest {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kLongestWait{2};

  void ask(TimePoint now) noexcept {
    if (!asked_) asked_ = now;
  }
  bool isOpen() const noexcept { return asked_.has_value(); }
  /// After a frame. @return true once for each request
  bool take(bool is_at_rest, TimePoint now) noexcept {
    if (!asked_ || !(is_at_rest || now - *asked_ >= kLongestWait)) return false;
    asked_.reset();
    return true;
  }

 private:
  std::optional<TimePoint> asked_;
};

}  // namespace lode::app
