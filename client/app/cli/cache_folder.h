#pragma once

#include <filesystem>

namespace lode::app {

/// Where the user's caches lie: XDG_CACHE_HOME, ~/.cache, or a folder for temporary files.
std::filesystem::path cacheFolder();

}  // namespace lode::app
