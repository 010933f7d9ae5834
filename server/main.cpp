#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <string>

#include "common/interrupted.h"
#include "server/app/command.h"

namespace {

constexpr int kDone = 0, kWorkFailed = 1, kWrongUsage = 2;

/// Says on one line of stderr what went wrong. @return the exit status.
int fail(std::string message, int status) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::fprintf(stderr, "lodestreamd: %s\n", message.c_str());
  return status;
}

/// @return the status, or that of failed work where stdout did not take all that was printed.
int endAfterPrinting(int status) {
  if (std::cout.flush() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  return fail(std::string("standard output cannot be written: ") + std::strerror(errno), kWorkFailed);
}

void addCommands(CLI::App& program) {
  lode::app::addBuildCommand(program);
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
  try {
    program.set_version_flag("--version", "lodestreamd " LODE_VERSION);
    program.require_subcommand(1);
    addCommands(program);
    program.parse(argc, argv);
    return endAfterPrinting(kDone);
  } catch (const CLI::Success& asked) {  // --help, --version
    return endAfterPrinting(program.exit(asked));
  } catch (const CLI::ParseError& error) {
    const std::string unknown = CLI::detail::join(program.remaining(true), " ");
    const std::string what = unknown.empty() ? error.what() : "not known here: " + unknown;
    return fail(what + ": " + lode::app::whereHelpIs(program), kWrongUsage);
  } catch (const lode::Error& error) {
    return fail(error.what(), error.code() == lode::ErrorCode::kUsage ? kWrongUsage : kWorkFailed);
  } catch (const std::bad_alloc&) {
    return fail("out of memory: give --memory a smaller budget or free some", kWorkFailed);
  } catch (const std::exception& error) {
    return fail(error.what(), kWorkFailed);
  }
}
