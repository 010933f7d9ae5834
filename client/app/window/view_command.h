#pragma once

#include <string>

#include "client/app/cli/common_options.h"
#include "client/app/window/look_options.h"

namespace CLI {
class App;
}

namespace lode::app {

struct ViewOptions {
  CommonOptions common;
  LookOptions look;
  double fps = 60;
  bool is_threshold_fixed = false;  ///< --pixels was given: the frame rate does not change the threshold
  std::string screenshot;           ///< if not empty: save a converged picture of the window there, and end
  int laps = 0;       ///< if > 0: fly the camera's path so many times, print frame times, and end
  bool json = false;  ///< print them as JSON
};

/// Declares `view`: a window that shows a model or a scene while it streams.
void declareView(CLI::App& program, int& exit_status);

}  // namespace lode::app
