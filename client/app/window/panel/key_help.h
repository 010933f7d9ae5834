#pragma once

#include <span>
#include <string_view>

#include "client/app/window/camera/camera_kind.h"

namespace lode::app {

/// What keys or the mouse do, for the help over the picture.
struct KeyHelp {
  std::string_view keys, what;
};

/// With one camera.
std::span<const KeyHelp> cameraHelp(CameraKind camera) noexcept;
/// With every camera.
std::span<const KeyHelp> commonHelp() noexcept;

}  // namespace lode::app
