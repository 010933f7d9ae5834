#pragma once

#include <string>

#include "client/app/cli/common_options.h"
#include "client/app/window/look_options.h"

namespace lode::app {

struct ViewOptions {
  CommonOptions common;
  LookOptions look;
  double fps = 60;
  bool is_threshold_fixed = false;  ///< whatever a frame takes
  std::string screenshot;  ///< if not empty: save the window there once the model has converged, and end
  int laps = 0;            ///< fly the camera's path so often, say what the frames took, and end
  bool json = false;       ///< say it as JSON
};

}  // namespace lode::app
