#pragma once

namespace CLI {
class App;
}

namespace lode::app {

/// Declares the subcommand `render`, which draws pictures off-screen. It draws each picture once the scene
/// has converged for the picture's camera.
void declareRender(CLI::App& program, int& exit_status);

}  // namespace lode::app
