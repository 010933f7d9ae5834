#include "server/app/command.h"

namespace lode::app {

void addDoctorCommand(CLI::App& program) {
  CLI::App* command =
      addCommand(program, "doctor", "Say what is in a PLY file and what is wrong (not there yet)");
  command->allow_extras();
  command->callback([] { notThereYet("doctor"); });
}

}  // namespace lode::app
