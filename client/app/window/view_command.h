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
  /// True if --pixels was given; the frame rate then does not change the threshold.
  bool is_threshold_fixed = false;
  /// File for one converged picture, after which the program ends; empty for none.
  std::string screenshot;
  /// Number of times to fly the camera's path, then print frame times and end; 0 for none.
  int laps = 0;
  bool json = false;  ///< true prints the frame times as JSON
};

/// Declares the subcommand `view`: a window that shows a model or a scene while its data streams.
void declareView(CLI::App& program, int& exit_status);

}  // namespace lode::app
