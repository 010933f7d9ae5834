#pragma once

namespace CLI {
class App;
}

namespace lode::app {

/// Declares the subcommand `render`, which draws pictures off-screen, each when the scene has converged for
/// the picture's camera.
void declareRender(CLI::App& program, int& exit_status);

}  // namespace lode::app
