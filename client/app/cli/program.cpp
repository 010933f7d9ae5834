#include "client/app/cli/program.h"

#include <string>

#include <CLI/CLI.hpp>

#include "common/command_line.h"
#include "common/error.h"

namespace lode::app {

void declareMissing(CLI::App& program, const char* name, const char* why) {
  CLI::App* command = program.add_subcommand(name, why);
  command->allow_extras();
  command->callback([name = std::string(name), why = std::string(why)] {
    throw Error(ErrorCode::kUsage, name + ": " + why);
  });
}

int runProgram(int argc, char** argv, DeclareCommand declare) {
  CLI::App program("Lodestream's client: shows models as they stream in from a server.", "lodestream");
  const auto declare_all = [&](int& exit_status) {
    program.set_version_flag("--version", "lodestream " LODE_VERSION);
    declare(program, exit_status);
  };
  return runCommandLine(program, argc, argv, declare_all, "give --memory-budget a smaller value");
}

}  // namespace lode::app
