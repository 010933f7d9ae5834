#pragma once

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

/// Adds a command with what all have in common (--version).
CLI::App* addCommand(CLI::App& program, const std::string& name, const std::string& description);

}  // namespace lode::app
