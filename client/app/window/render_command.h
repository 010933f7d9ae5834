#pragma once

namespace CLI {
class App;
}

namespace lode::app {

/// Declares `render`: pictures drawn off-screen, each once the model has converged for its camera.
void declareRender(CLI::App& program, int& exit_status);

}  // namespace lode::app
