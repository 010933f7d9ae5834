#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include <CLI/CLI.hpp>

#include "common/error.h"

/// The commands of lodestreamd. Each function adds one to the command line, with a callback that does the
/// work and throws Error when it fails.
namespace lode::app {

void addBuildCommand(CLI::App& program);
void addDoctorCommand(CLI::App& program);
void addServeCommand(CLI::App& program);
void addInfoCommand(CLI::App& program);
void addVerifyCommand(CLI::App& program);
void addExportCommand(CLI::App& program);
void addSampleCommand(CLI::App& program);

/// A check of options: CLI11 takes "-5" for a very large one. @return what is wrong, if anything.
std::string wholeNumber(const std::string& text);

/// Adds an option that takes a count of bytes (see parseByteSize()), from `least` to `most`.
CLI::Option* addByteSize(CLI::App& command, const std::string& name, uint64_t& value, const std::string& help,
                         uint64_t least = 1, uint64_t most = std::numeric_limits<uint64_t>::max());

/// Adds a command with what all have in common (--version).
CLI::App* addCommand(CLI::App& program, const std::string& name, const std::string& description);

}  // namespace lode::app
