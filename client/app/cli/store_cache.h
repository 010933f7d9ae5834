#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "client/app/cli/file_lock.h"

namespace lode::app {

/// In the folder of a source: whoever builds there holds it.
constexpr std::string_view kStoreBuildLock = "lock";
/// Beside a store, in the folder of its version: what the build said. Its time is that of the store's last
/// use.
constexpr std::string_view kBuildRecord = "built.json";

/// How much all stores that are built of PLY files may take together: a tenth of the disk that they lie on,
/// at least 20 GB, but not more than half of it.
/// @param disk_bytes  its size.
uint64_t storeCacheBytes(uint64_t disk_bytes) noexcept;
/// The same. @param stores  the folder with one for each source.
uint64_t storeCacheBytes(const std::filesystem::path& stores);

/// Counts as a use of the store now, and keeps other programs from removing it as long as what is returned
/// lives. Call it with the lock of the source.
FileLock useStore(const std::filesystem::path& store);

/// Removes what was built of the sources whose stores were not used for the longest time until all take at
/// most so many bytes; nothing that is in use or being built.
void trimStores(const std::filesystem::path& stores, uint64_t max_bytes);

}  // namespace lode::app
