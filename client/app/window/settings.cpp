#include "client/app/window/settings.h"

#include <algorithm>
#include <cmath>

namespace lode::app {

size_t memoryStepAt(uint64_t bytes) noexcept {
  const auto distance = [bytes](uint64_t step) {
    return std::abs(std::log(static_cast<double>(step)) - std::log(static_cast<double>(bytes)));
  };
  return static_cast<size_t>(std::ranges::min_element(kMemorySteps, {}, distance) - kMemorySteps.begin());
}

}  // namespace lode::app
