#pragma once

#include <string>

#include "client/render/renderer.h"

namespace CLI {
class App;
}

namespace lode::app {

/// Options of view and render that choose how a model looks.
struct LookOptions {
  std::string show = "surface";
  float exposure = 1;
};

/// Declares --show, --unlit and --exposure on a subcommand.
void addLookOptions(CLI::App& command, LookOptions& options);

render::DrawStyle styleOf(const LookOptions& options);

}  // namespace lode::app
