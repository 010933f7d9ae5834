#pragma once

namespace CLI {
class App;
}

namespace lode::app {

/// Declares `view`: a window in which a model is looked at while it streams.
void declareView(CLI::App& program, int& exit_status);

}  // namespace lode::app
