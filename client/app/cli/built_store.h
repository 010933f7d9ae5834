#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "client/app/cli/store_cache.h"

namespace lode::app {

/// Receives a build's stage and its progress, 0..1, on the thread that calls builtStore().
using BuildWatch = std::function<void(std::string_view stage, double fraction)>;

struct BuiltStore {
  std::filesystem::path path;
  FileLock in_use;                         ///< keeps other programs from removing the store
  std::vector<std::string> warnings = {};  ///< warnings of the build
};

/// Returns the store of a PLY file. Builds it into the user's cache unless the cache has a store of the same
/// file, images and version of the builder. Waits if another program builds it. Prints warnings of the build
/// on stderr. After a build, removes the least recently used stores above the limit.
/// @param announce   prints progress on stderr if that is a terminal.
/// @param stop       aborts the wait or the build: throws Error.
/// @param watch      receives the progress instead of stderr.
/// @param max_bytes  limit for all stores in the cache; by default storeCacheBytes().
/// @throws Error.
BuiltStore builtStore(const std::filesystem::path& ply, bool announce, const std::stop_token& stop,
                      const BuildWatch& watch, std::optional<uint64_t> max_bytes = {});

}  // namespace lode::app
