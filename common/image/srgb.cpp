#include "common/image/srgb.h"

#include <algorithm>
#include <cmath>

namespace lode {

double linearOf(uint8_t srgb) noexcept {
  const double encoded = srgb / 255.0;
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

uint8_t srgbOf(double linear) noexcept {
  const double part = std::clamp(linear, 0.0, 1.0);
  const double encoded = part <= 0.0031308 ? part * 12.92 : 1.055 * std::pow(part, 1 / 2.4) - 0.055;
  return static_cast<uint8_t>(std::lround(255 * encoded));
}

}  // namespace lode
