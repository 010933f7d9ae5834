#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/plan/build_options.h"
#include "server/ingest/soup/uv_grid.h"
#include "server/ingest/textures/texture_images.h"

namespace lode::ingest {

/// Tiles of the images, encoded, in a temporary file.
struct StagedTextures {
  struct Place {
    uint64_t offset = 0;
    uint32_t bytes = 0;
  };
  struct Texture {
    std::string name;  ///< fit for a texture set
    uint32_t width = 0, height = 0;
    std::vector<Place> tiles;  ///< in the order of lode::Texture's
  };
  /// Name of the tiles' file, which lasts.
  static constexpr std::string_view kFile = "tiles";

  std::vector<Texture> textures;

  void save(RecordWriter& record) const;
  /// What save() noted. @throws Error kFormat.
  static StagedTextures load(RecordReader& record);
};

/// Stage "textures": decodes the images, makes their levels and encodes the tiles, on options.threads
/// threads at most; the tiles do not depend on how many. One image is in memory at a time. An image that has
/// a problem or cannot be read is a warning, and its texture has no tiles.
/// @param image_bytes  that an image may take (MemoryPlan).
/// @throws Error kIo.
StagedTextures stageTextures(const BuildOptions& options, std::span<const TextureImage> images,
                             const UvGrid& grid, Spool& tiles, uint64_t image_bytes,
                             const BuildProgress& progress, std::vector<std::string>& warnings);

}  // namespace lode::ingest
