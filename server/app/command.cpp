#include "server/app/command.h"

#include "common/byte_size.h"
#include "server/app/json_output.h"

namespace lode::app {

std::string wholeNumber(const std::string& text) {
  const bool is_number = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
  return is_number ? "" : "must be a whole number such as 2000000, not " + text;
}

CLI::Option* addByteSize(CLI::App& command, const std::string& name, uint64_t& value, const std::string& help,
                         uint64_t least, uint64_t most) {
  const auto read = [&value, name, least, most](const std::string& text) {
    try {
      value = parseByteSize(text);
    } catch (const Error& error) {
      throw CLI::ValidationError(name, error.what());
    }
    if (value < least) throw CLI::ValidationError(name, text + " is less than " + describeBytes(least));
    if (value > most) throw CLI::ValidationError(name, text + " is more than " + describeBytes(most));
  };
  return command.add_option_function<std::string>(name, read, help)->type_name("BYTES");
}

CLI::App* addCommand(CLI::App& program, const std::string& name, const std::string& description) {
  CLI::App* command = program.add_subcommand(name, description);
  command->set_version_flag("--version", "lodestreamd " LODE_VERSION);
  return command;
}

}  // namespace lode::app
