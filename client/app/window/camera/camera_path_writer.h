#pragma once

#include <string>

#include "client/core/view/camera_path.h"

namespace lode::core {

/// A path as JSON that parseCameraPath() reads as the same path.
std::string writeCameraPath(const CameraPath& path);

}  // namespace lode::core
