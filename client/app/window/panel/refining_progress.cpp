#include "client/app/window/panel/refining_progress.h"

#include <algorithm>
#include <cmath>

namespace lode::app {
namespace {

constexpr double kAlmost = 0.99;  ///< parts are finer than asked for before their neighbours have come

}  // namespace

double RefiningProgress::see(float error_px, float threshold_px, bool converged) noexcept {
  if (converged) {
    start_px_ = 0;
    return 1;
  }
  start_px_ = std::max(start_px_, error_px);
  if (start_px_ <= threshold_px) return kAlmost;
  const double done = std::log2(start_px_ / std::max(error_px, threshold_px));
  return std::min(kAlmost, done / std::log2(start_px_ / threshold_px));
}

}  // namespace lode::app
