#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include <glm/glm.hpp>

#include "server/store/reader.h"

namespace lode::tiles {

struct TileExportOptions {
  std::filesystem::path folder;  ///< folder to write; a new or an empty one
  glm::dmat4 root_transform{1};  ///< see rootTransform()
  unsigned threads = 1;          ///< the files do not depend on this number
};

/// Sums over the files that were written.
struct TileExportReport {
  uint64_t tiles = 0;        ///< tiles with content
  uint64_t pages = 0;        ///< JSON files
  uint64_t glbs = 0;         ///< GLB files
  uint64_t images = 0;       ///< image files that GLB files share
  uint64_t json_bytes = 0;   ///< size of all JSON files
  uint64_t glb_bytes = 0;    ///< size of all GLB files
  uint64_t image_bytes = 0;  ///< size of all image files
};

/// Receives the number of GLB files done and of all GLB files; image files do not count. An exception ends
/// the export.
using TileExportProgress = std::function<void(uint64_t done, uint64_t total)>;

/// Writes a store as 3D Tiles: all files of a TileWriter. Keeps in memory the store's hierarchy, one page
/// and, per thread, one payload with its mesh and atlas, or one image. The folder gets its name when it is
/// complete. Calls `progress` on the calling thread.
/// @throws Error kUsage if the folder exists and is not empty; kIo, kFormat or kLimit, naming file and place.
TileExportReport exportTiles(const store::Reader& reader, const TileExportOptions& options,
                             const TileExportProgress& progress);

}  // namespace lode::tiles
