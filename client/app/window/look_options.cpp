#include "client/app/window/look_options.h"

#include <CLI/CLI.hpp>

#include "common/command_line.h"

namespace lode::app {

void addLookOptions(CLI::App& command, LookOptions& options) {
  const auto is_known = [](const std::string& name) {
    return render::colorModeNamed(name) ? std::string()
                                        : "'" + name + "' is none of " + render::colorModeNames();
  };
  auto* show = command.add_option("--show", options.show, "colour mode: " + render::colorModeNames())
                   ->type_name("NAME")
                   ->check(is_known)
                   ->capture_default_str();
  command
      .add_flag_callback(
          "--unlit", [&options] { options.show = nameOf(render::ColorMode::kUnlit); },
          "show colours without light")
      ->excludes(show);
  command.add_option("--exposure", options.exposure, "factor that multiplies the light")
      ->check(numberFrom(0.01, 100.0))
      ->capture_default_str();
}

render::DrawStyle styleOf(const LookOptions& options) {
  render::DrawStyle style;
  style.show = render::colorModeNamed(options.show).value_or(render::ColorMode::kSurface);
  style.exposure = options.exposure;
  return style;
}

}  // namespace lode::app
