#pragma once

namespace CLI {
class App;
}

namespace lode::app {

void declareLoadtest(CLI::App& program, int& exit_status);

}  // namespace lode::app
