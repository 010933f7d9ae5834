#pragma once

#include <string>

#include "client/app/cli/common_options.h"
#include "client/app/window/look_options.h"

namespace CLI {
class App;
}

namespace lode::app {

/// Options of the subcommand `view`.
struct ViewOptions {
  CommonOptions common;
  LookOptions look;
  double fps = 60;
  bool is_threshold_fixed = false;  ///< --pixels was given: the frame rate does not change the threshold
  std::string screenshot;           ///< if not empty: file in which to save a converged picture; then end
  int laps = 0;       ///< if > 0: number of times to fly the camera's path; then print frame times and end
  bool json = false;  ///< print the frame times as JSON
};

/// Declares the subcommand `view`: a window that shows a model or a scene while its data streams.
void declareView(CLI::App& program, int& exit_status);

}  // namespace lode::app
