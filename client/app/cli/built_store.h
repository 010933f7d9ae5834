#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "client/app/cli/build_step.h"
#include "client/app/cli/store_cache.h"
#include "client/app/cli/target.h"
#include "common/io/copied_input.h"

namespace lode::app {

/// A store in the user's cache.
struct BuiltStore {
  std::filesystem::path path;
  FileLock in_use;                         ///< lock that keeps other programs from removing the store
  std::vector<std::string> warnings = {};  ///< warnings of the build
  bool is_preview = false;                 ///< the store is only a preview: PlyFile::preview_only
};

/// Copies standard input, a PLY file, into the cache. builtStore() builds the store of a copy beside it, and
/// removes the copy when the store is complete. The destructor of the copy removes the store.
/// @throws Error as CopiedInput does; kIo also if the cache cannot be used.
std::shared_ptr<const CopiedInput> copyStandardInput();
/// Returns true if the path is that of a copy that copyStandardInput() has made.
bool isCopyOfInput(const std::filesystem::path& path);

/// Returns the place of the preview that a build of a cached store makes. Both files have the same name, so
/// that a server serves both stores under one name.
std::filesystem::path previewBeside(const std::filesystem::path& store);

/// Returns the store of a PLY file. Builds the store into the user's cache, unless the cache already contains
/// a store that the same version of the builder has built from the same file and images. Waits while another
/// program builds the store. Prints warnings of the build on stderr. After a build, removes the least
/// recently used stores until the cache is within its limit.
/// @param announce   true to print progress on stderr: a bar on a terminal, else a line every five seconds.
/// @param stop       stop token; a stop request aborts the wait or the build, and the function throws an
///                   Error. The next call for the same file resumes the build.
/// @param watch      watch of the build.
/// @param max_bytes  limit for all stores in the cache together; storeCacheBytes() by default.
/// @throws Error.
BuiltStore builtStore(const PlyFile& ply, bool announce, const std::stop_token& stop, const BuildWatch& watch,
                      std::optional<uint64_t> max_bytes = {});

}  // namespace lode::app
