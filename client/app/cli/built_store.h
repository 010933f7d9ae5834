#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "client/app/cli/file_lock.h"

namespace lode::app {

/// Told of a build's stage and how much of it is done, 0..1, on the thread that builds.
using BuildWatch = std::function<void(std::string_view stage, double fraction)>;

struct BuiltStore {
  std::filesystem::path path;
  FileLock in_use;                         ///< no program removes it before this ends
  std::vector<std::string> warnings = {};  ///< of the build
};

/// The store of a PLY file: built into the XDG cache, unless it is there and neither the file nor an image
/// that it names nor the builder has changed since. Another program that builds it is waited for. Warnings of
/// the build go to stderr each time. Stores beyond the limit that were not used for the longest time go when
/// one is built.
/// @param announce   progress goes to stderr if that is a terminal.
/// @param stop       ends the wait or the build, which then counts as failed.
/// @param watch      told of the progress, which then does not go to stderr.
/// @param max_bytes  of all stores there; none: storeCacheBytes().
/// @throws Error.
BuiltStore builtStore(const std::filesystem::path& ply, bool announce, const std::stop_token& stop,
                      const BuildWatch& watch, std::optional<uint64_t> max_bytes = {});

}  // namespace lode::app
