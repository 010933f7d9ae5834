#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include <CLI/CLI.hpp>

#include "common/error.h"

/// The commands of lodestreamd. Each function adds a command whose callback does the work and throws Error on
/// failure.
namespace lode::app {

void addBuildCommand(CLI::App& program, int& exit_status);
void addDoctorCommand(CLI::App& program);
void addServeCommand(CLI::App& program);
void addInfoCommand(CLI::App& program);
void addVerifyCommand(CLI::App& program);
void addExportCommand(CLI::App& program);
void addSampleCommand(CLI::App& program);

/// Checks that an option is a whole number, because CLI11 parses "-5" as a very large number. Returns an
/// error message, or "" if the text is valid.
std::string wholeNumber(const std::string& text);

/// Adds an option for a number of bytes (see parseByteSize()) from `least` to `most`.
CLI::Option* addByteSize(CLI::App& command, const std::string& name, uint64_t& value, const std::string& help,
                         uint64_t least = 1, uint64_t most = std::numeric_limits<uint64_t>::max());

/// Adds a command with the options that all commands share (--version).
CLI::App* addCommand(CLI::App& program, const std::string& name, const std::string& description);

}  // namespace lode::app
