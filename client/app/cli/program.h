#pragma once

#include "client/app/cli/common_options.h"

namespace lode::app {

/// The client with the commands that `declare` adds. Whatever goes wrong is said on one line of stderr.
/// @return the exit status: 0 done, 1 the work failed, 2 used wrongly.
int runProgram(int argc, char** argv, DeclareCommand declare);

/// A command that this program knows by name only, and refuses.
void declareMissing(CLI::App& program, const char* name, const char* why);

}  // namespace lode::app
