#pragma once

namespace CLI {
class App;
}

namespace lode::app {

// Each adds its command; see DeclareCommand.
void declareLoadtest(CLI::App& program, int& exit_status);
void declareReplay(CLI::App& program, int& exit_status);

}  // namespace lode::app
