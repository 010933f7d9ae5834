#include "server/app/command.h"

namespace lode::app {

CLI::App* addCommand(CLI::App& program, const std::string& name, const std::string& description) {
  CLI::App* command = program.add_subcommand(name, description);
  command->set_version_flag("--version", "lodestreamd " LODE_VERSION);
  return command;
}

void addMissingOption(CLI::App& command, const std::string& name, const std::string& description) {
  command.add_option_function<std::string>(
      name, [name](const std::string&) { notThereYet(name); }, description + " (not there yet)");
}

void addMissingFlag(CLI::App& command, const std::string& name, const std::string& description) {
  command.add_flag_callback(
      name, [name] { notThereYet(name); }, description + " (not there yet)");
}

void notThereYet(const std::string& what) {
  throw Error(ErrorCode::kUsage, what + " is not there yet in version " LODE_VERSION);
}

}  // namespace lode::app
