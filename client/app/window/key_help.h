#pragma once

#include <span>
#include <string_view>

namespace lode::app {

/// What keys or the mouse do, for the help over the picture.
struct KeyHelp {
  std::string_view keys, what;
};

/// With the camera that orbits or the one that flies.
std::span<const KeyHelp> cameraHelp(bool flying) noexcept;
/// With every camera.
std::span<const KeyHelp> commonHelp() noexcept;

}  // namespace lode::app
