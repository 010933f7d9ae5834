#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <string>

#include <CLI/CLI.hpp>

#include "client/app/cli/common_options.h"
#include "client/app/cli/loadtest_command.h"
#include "common/error.h"
#ifdef LODE_GL
#include "client/app/window/render_command.h"
#include "client/app/window/view_command.h"
#endif

namespace {

constexpr int kDone = 0, kWorkFailed = 1, kWrongUsage = 2;

/// Says on one line of stderr what went wrong. @return the exit status.
int fail(std::string message, int status) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::fprintf(stderr, "lodestream: %s\n", message.c_str());
  return status;
}

/// @return the status, or that of failed work where stdout did not take all that was printed.
int endAfterPrinting(int status) {
  if (std::cout.flush() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  return fail(std::string("standard output cannot be written: ") + std::strerror(errno), kWorkFailed);
}

#ifndef LODE_GL
/// A command that this program knows by name only.
void declareMissing(CLI::App& program, const std::string& name, const std::string& why) {
  CLI::App* command = program.add_subcommand(name, why);
  command->allow_extras();
  command->callback([name, why] { throw lode::Error(lode::ErrorCode::kUsage, name + ": " + why); });
}
#endif

void declareCommands(CLI::App& program, int& exit_status) {
#ifdef LODE_GL
  lode::app::declareView(program, exit_status);
  lode::app::declareRender(program, exit_status);
#else
  for (const char* name : {"view", "render"})
    declareMissing(program, name, "built without OpenGL; use a build with it");
#endif
  lode::app::declareFetch(program, exit_status);
  lode::app::declareReplay(program, exit_status);
  lode::app::declareLoadtest(program, exit_status);
  lode::app::declareList(program, exit_status);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program("Lodestream's client: shows models as they stream in from a server.", "lodestream");
  int exit_status = kDone;
  try {
    program.set_version_flag("--version", "lodestream " LODE_VERSION);
    program.require_subcommand(1);
    declareCommands(program, exit_status);
    program.parse(argc, argv);
    return endAfterPrinting(exit_status);
  } catch (const CLI::Success& asked) {  // --help, --version
    return endAfterPrinting(program.exit(asked));
  } catch (const CLI::ExtrasError&) {
    return fail(
        "not known here: " + CLI::detail::join(program.remaining(true), " ") + ": see lodestream --help",
        kWrongUsage);
  } catch (const CLI::ParseError& error) {
    return fail(std::string(error.what()) + ": see lodestream --help", kWrongUsage);
  } catch (const lode::Error& error) {
    return fail(error.what(), error.code() == lode::ErrorCode::kUsage ? kWrongUsage : kWorkFailed);
  } catch (const std::bad_alloc&) {
    return fail("out of memory: give --memory-budget a smaller value", kWorkFailed);
  } catch (const std::exception& error) {
    return fail(error.what(), kWorkFailed);
  }
}
