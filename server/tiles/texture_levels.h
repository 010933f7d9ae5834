#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "common/image/image.h"
#include "common/image/tile_image.h"
#include "server/store/reader.h"

namespace lode::tiles {

/// Reads parts of a store's textures at any level, down to one texel. Computes the levels that are coarser
/// than the stored ones. Caches a few decoded tiles. Not thread safe.
class TextureLevels {
 public:
  /// @param reader  must outlive the object.
  explicit TextureLevels(const store::Reader& reader) : reader_(reader) {}

  /// Returns the number of the level with one texel.
  uint32_t coarsest(uint32_t texture) const;
  /// Returns the size of a level in texels.
  glm::uvec2 size(uint32_t texture, uint32_t level) const;
  /// Returns true if the header of a texture's tiles says that texels may be transparent.
  bool mayBeClear(uint32_t texture) const;
  /// Returns true if the tiles of a texture are JPEG files, which have no alpha.
  bool isJpeg(uint32_t texture) const;

  /// Copies texels of a level. The image repeats beyond its edges.
  /// @param first  texel at which the part begins; may be negative.
  /// @throws Error kIo, kFormat or kLimit.
  Image part(uint32_t texture, uint32_t level, glm::ivec2 first, glm::uvec2 size);

 private:
  const Texture& textureOf(uint32_t texture) const { return reader_.textures().textures[texture]; }
  std::vector<std::byte> coarsestTile(uint32_t texture) const;
  const TileImage& tile(uint32_t texture, size_t number, glm::uvec2 inner_size);
  const Image& computed(uint32_t texture, uint32_t level);

  const store::Reader& reader_;
  std::map<std::pair<uint32_t, size_t>, TileImage> tiles_;   ///< decoded tiles, by texture and tile index
  std::map<std::pair<uint32_t, uint32_t>, Image> computed_;  ///< coarser levels than the stored ones
};

}  // namespace lode::tiles
