#include "client/app/window/view_command.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>

#include <CLI/CLI.hpp>

#include "client/app/window/output/picture_file.h"
#include "client/app/window/viewer.h"
#include "common/command_line.h"

namespace lode::app {

void declareView(CLI::App& program, int& exit_status) {
  CLI::App* command = program.add_subcommand(
      "view", "Shows a model or a scene in a window while it streams; F1 lists the keys");
  const auto options = std::make_shared<ViewOptions>();
  addCommonOptions(*command, options->common, Takes::kScenesToo);
  CLI::Option* const target = command->get_option("target")->required(false);
  addFadeOption(*command, options->common);
  CLI::Option* const screenshot =
      command
          ->add_option("--screenshot", options->screenshot,
                       "save a picture of the window once it has converged, then exit")
          ->type_name("OUT.png");
  command
      ->add_option(
          "--fps", options->fps,
          "frame rate while the camera moves, kept by a coarser threshold; --pixels fixes the threshold")
      ->check(numberFrom(1.0, 1000.0))
      ->capture_default_str();
  CLI::Option* const laps = command
                                ->add_option("--laps", options->laps,
                                             "fly the path of --camera (default: an orbit) this number of "
                                             "times, print frame times, then exit")
                                ->check(CLI::Range(1, 1000))
                                ->excludes(screenshot);
  command->add_flag("--json", options->json, "print the frame times as one JSON object, with each frame")
      ->needs(laps);
  addLookOptions(*command, options->look);
  const CLI::Option* const pixels = command->get_option("--pixels");
  screenshot->needs(target);
  laps->needs(target);
  command->callback([options, pixels, &exit_status] {
    if (options->common.target.empty() && !hasDisplay()) throw CLI::RequiredError("target");
    options->is_threshold_fixed = pixels->count() > 0;
    if (!options->screenshot.empty()) checkPictureFile(options->common.target, options->screenshot);
    takeStandardInput(options->common);
    exit_status = Viewer(*options).run() ? command_line::kDone : command_line::kWorkFailed;
  });
}

bool hasDisplay() {
  return std::ranges::any_of(std::array{"DISPLAY", "WAYLAND_DISPLAY"}, [](const char* name) {
    const char* const display = std::getenv(name);
    return display != nullptr && *display != '\0';
  });
}

}  // namespace lode::app
