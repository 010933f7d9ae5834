#include "client/app/cli/program.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <string>

#include <CLI/CLI.hpp>

#include "common/error.h"

namespace lode::app {

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

/// Ends a message about wrong usage: "see lodestream fetch --help", of the command that was called, if any.
std::string whereHelpIs(const CLI::App& program) {
  std::string words = "see " + program.get_name();
  for (const CLI::App* command : program.get_subcommands()) words += " " + command->get_name();
  return words + " --help";
}

}  // namespace

void declareMissing(CLI::App& program, const char* name, const char* why) {
  CLI::App* command = program.add_subcommand(name, why);
  command->allow_extras();
  command->callback([name = std::string(name), why = std::string(why)] {
    throw Error(ErrorCode::kUsage, name + ": " + why);
  });
}

int runProgram(int argc, char** argv, DeclareCommand declare) {
  CLI::App program("Lodestream's client: shows models as they stream in from a server.", "lodestream");
  int exit_status = kDone;
  try {
    program.set_version_flag("--version", "lodestream " LODE_VERSION);
    program.require_subcommand(1);
    declare(program, exit_status);
    program.parse(argc, argv);
    return endAfterPrinting(exit_status);
  } catch (const CLI::Success& asked) {  // --help, --version
    return endAfterPrinting(program.exit(asked));
  } catch (const CLI::ParseError& error) {
    const std::string unknown = CLI::detail::join(program.remaining(true), " ");
    const std::string what = unknown.empty() ? error.what() : "not known here: " + unknown;
    return fail(what + ": " + whereHelpIs(program), kWrongUsage);
  } catch (const Error& error) {
    return fail(error.what(), error.code() == ErrorCode::kUsage ? kWrongUsage : kWorkFailed);
  } catch (const std::bad_alloc&) {
    return fail("out of memory: give --memory-budget a smaller value", kWorkFailed);
  } catch (const std::exception& error) {
    return fail(error.what(), kWorkFailed);
  }
}

}  // namespace lode::app
