#include "common/command_line.h"
#include "common/io/interrupted.h"
#include "server/app/command.h"

namespace {

void addCommands(CLI::App& program, int& exit_status) {
  lode::app::addBuildCommand(program, exit_status);
  lode::app::addDoctorCommand(program);
  lode::app::addServeCommand(program);
  lode::app::addInfoCommand(program);
  lode::app::addVerifyCommand(program);
  lode::app::addExportCommand(program);
  lode::app::addSampleCommand(program);
}

}  // namespace

int main(int argc, char** argv) {
  lode::endCleanlyWhenInterrupted();
  CLI::App program("Lodestream's server: builds stores from PLY files, serves, checks and exports them.",
                   "lodestreamd");
  const auto declare = [&](int& exit_status) {
    program.set_version_flag("--version", "lodestreamd " LODE_VERSION);
    addCommands(program, exit_status);
  };
  return lode::runCommandLine(program, argc, argv, declare,
                              {"give a smaller --memory or --memory-budget, or free memory"});
}
