#include "client/app/window/redraws.h"

#include <algorithm>

namespace lode::app {

void Redraws::add(Difference difference, TimePoint now) noexcept {
  if (difference == Difference::kPicture) frames_ = 1 + kFramesToSettle;
  if (difference == Difference::kProgress && now - drawn_ >= kProgressInterval)
    frames_ = std::max(frames_, 1);
}

void Redraws::draw(TimePoint now) noexcept {
  frames_ = std::max(0, frames_ - 1);
  drawn_ = now;
}

}  // namespace lode::app
