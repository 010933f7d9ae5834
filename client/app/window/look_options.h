#pragma once

#include <string>

#include "client/render/renderer.h"

namespace CLI {
class App;
}

namespace lode::app {

/// How view and render show a model, as their options say it.
struct LookOptions {
  std::string show = "surface";
  float exposure = 1;
};

/// Declares --show, --unlit and --exposure on a subcommand.
void addLookOptions(CLI::App& command, LookOptions& options);

render::DrawStyle styleOf(const LookOptions& options);

}  // namespace lode::app
