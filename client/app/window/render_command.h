#pragma once

namespace CLI {
class App;
}

namespace lode::app {

/// Declares `render`: draws pictures off-screen, each once the scene has converged for its camera.
void declareRender(CLI::App& program, int& exit_status);

}  // namespace lode::app
