#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace lode::app {

/// Arguments of `export --tiles`.
struct TilesArguments {
  std::filesystem::path store, folder;
  std::string up;                 ///< axis as typed; empty: guess it
  std::optional<std::string> at;  ///< longitude, latitude and height as typed
  unsigned threads = 0;
  bool json = false, quiet = false;
};

/// Adds the options that need `--tiles`. @param tiles  the option `--tiles`.
void addTilesOptions(CLI::App& command, CLI::Option& tiles, TilesArguments& arguments);

/// Writes the store as 3D Tiles, with progress on stderr and a summary on stdout. A signal ends the export
/// and removes its files. @throws Error.
void exportAsTiles(const TilesArguments& arguments);

}  // namespace lode::app
