#pragma once

namespace CLI {
class App;
}

namespace lode::app {

// Each of these functions adds a subcommand whose callback does the work and can set the exit status.
void declareLoadtest(CLI::App& program, int& exit_status);
void declareReplay(CLI::App& program, int& exit_status);

}  // namespace lode::app
