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
  /// True if --pixels was given; a moving camera then does not raise the threshold.
  bool is_threshold_fixed = false;
  /// File for one converged picture, after which the program exits; empty: none.
  std::string screenshot;
  /// Number of times to fly the camera's path before printing frame times and exiting; 0: no flight.
  int laps = 0;
  bool json = false;  ///< true to print the frame times as JSON
};

/// Declares the subcommand `view`: a window that shows a model or a scene while its data streams. Without a
/// target, the window asks for one.
void declareView(CLI::App& program, int& exit_status);

/// Returns true if the environment names a display for windows.
bool hasDisplay();

}  // namespace lode::app
