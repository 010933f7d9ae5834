#include "server/app/command.h"

namespace lode::app {

CLI::App* addCommand(CLI::App& program, const std::string& name, const std::string& description) {
  CLI::App* command = program.add_subcommand(name, description);
  command->set_version_flag("--version", "lodestreamd " LODE_VERSION);
  return command;
}

}  // namespace lode::app
