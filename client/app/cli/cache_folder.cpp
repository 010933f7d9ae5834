#include "client/app/cli/cache_folder.h"

#include <cstdlib>
#include <string>

#include <unistd.h>

namespace lode::app {

namespace fs = std::filesystem;

fs::path cacheFolder() {
  if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg && fs::path(xdg).is_absolute())
    return fs::path(xdg) / "lodestream";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "lodestream";
  return fs::temp_directory_path() / ("lodestream-" + std::to_string(getuid()));
}

}  // namespace lode::app
