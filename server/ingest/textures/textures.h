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

/// Encoded tiles of the images, in a temporary file.
struct StagedTextures {
  struct Place {
    uint64_t offset = 0;
    uint32_t bytes = 0;
  };
  struct Texture {
    std::string name;  ///< name of the image, shortened and printable, as a texture set requires
    uint32_t width = 0, height = 0;
    /// Places in the order of lode::Texture::tiles; empty if the image has a problem.
    std::vector<Place> tiles;
  };
  /// Name of the file with the tiles, which outlives a killed build.
  static constexpr std::string_view kFile = "tiles";

  std::vector<Texture> textures;
  std::vector<std::string> warnings;  ///< of stageTextures(); save() does not record them

  void save(RecordWriter& record) const;
  /// Restores what save() recorded. @throws Error kFormat.
  static StagedTextures load(RecordReader& record);
};

/// Decodes the images, computes their levels and encodes the tiles, on at most options.threads threads. The
/// tiles do not depend on the number of threads. Only one image is in memory at a time. If an image has a
/// problem or cannot be read, adds a warning to the result; the texture of that image then has no tiles.
/// @param image_bytes  limit per image (MemoryPlan).
/// @throws Error kIo.
StagedTextures stageTextures(const BuildOptions& options, std::span<const TextureImage> images,
                             const UvGrid& grid, Spool& tiles, uint64_t image_bytes,
                             const BuildProgress& progress);

}  // namespace lode::ingest
