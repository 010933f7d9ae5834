#include <string>

#include <CLI/CLI.hpp>

#include "client/app/cli/common_options.h"
#include "client/app/cli/remedy_words.h"
#include "client/app/cli/target.h"
#include "client/loadtest/loadtest_command.h"
#include "common/command_line.h"
#include "common/error.h"
#include "common/io/interrupted.h"
#ifdef LODE_GL
#include "client/app/window/render_command.h"
#include "client/app/window/view_command.h"
#endif

namespace {

using namespace lode::app;

#ifndef LODE_GL
/// Declares a command that this build lacks, so that calling it reports the reason.
void declareMissing(CLI::App& program, const std::string& name, const std::string& why) {
  CLI::App* command = program.add_subcommand(name, why);
  command->allow_extras();
  command->callback([name, why] { throw lode::Error(lode::ErrorCode::kUsage, name + ": " + why); });
}
#endif

void declareCommands(CLI::App& program, int& exit_status) {
  program.set_version_flag("--version", "lodestream " LODE_VERSION);
#ifdef LODE_GL
  declareView(program, exit_status);
  declareRender(program, exit_status);
#else
  for (const char* name : {"view", "render"})
    declareMissing(program, name, "built without OpenGL; use a build with it");
#endif
  declareFetch(program, exit_status);
  declareReplay(program, exit_status);
  declareLoadtest(program, exit_status);
  declareList(program, exit_status);
  declareStore(program, exit_status);
}

}  // namespace

int main(int argc, char** argv) {
  lode::endCleanlyWhenInterrupted();
  CLI::App program(
      "Shows models while they stream from a Lodestream server.\n"
      "lodestream TARGET [OPTIONS] opens a window, as lodestream view TARGET [OPTIONS] does. "
      "Without arguments, the window asks for a file.",
      "lodestream");
#ifdef LODE_GL
  const lode::DefaultCommand view{"view", looksLikeTarget, hasDisplay};
#else
  const lode::DefaultCommand view{"view", looksLikeTarget};
#endif
  const auto declare = [&](int& exit_status) { declareCommands(program, exit_status); };
  return lode::runCommandLine(program, argc, argv, declare,
                              {.more_memory = "give --memory-budget a smaller value",
                               .message_of = lode::app::messageOf,
                               .default_command = view});
}
