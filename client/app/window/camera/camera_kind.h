#pragma once

#include <cstdint>

namespace lode::app {

enum class CameraKind : uint8_t { kOrbit, kFly, kWalk };
constexpr int kCameraKindCount = 3;

}  // namespace lode::app
