#include "server/store/texture_export.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "common/mesh_images/image_names.h"
#include "common/mesh_images/png_writer.h"
#include "common/tile_image.h"

namespace lode::store {
namespace {

/// @return whether the image has alpha.
bool exportImage(const Reader& reader, const Texture& texture, const std::filesystem::path& path) {
  const auto tileAt = [&](uint32_t x, uint32_t y) {
    return reader.readBlob(texture.tiles[tileIndex(texture, 0, x, y)].number);
  };
  const bool has_alpha = tileKind(tileAt(0, 0)) == TileKind::kWebp;
  std::vector<TileImage> tiles(tilesAcross(texture, 0));
  writePng(path, {texture.width, texture.height}, has_alpha, [&](uint32_t y, std::span<glm::u8vec4> row) {
    const uint32_t line = y % kTileInnerPx;
    if (line == 0)
      for (uint32_t x = 0; x < tiles.size(); ++x)
        tiles[x] = decodeTile(tileAt(x, y / kTileInnerPx),
                              tileInnerSize(texture, 0, x, y / kTileInnerPx) + 2 * kTileGutterPx);
    auto to = row.begin();
    for (const TileImage& tile : tiles) {
      const auto* const from = tile.texels.data() + size_t{line + kTileGutterPx} * tile.size.x;
      to = std::copy(from + kTileGutterPx, from + tile.size.x - kTileGutterPx, to);
    }
  });
  return has_alpha;
}

}  // namespace

ImageFiles exportTextures(const Reader& reader, const std::filesystem::path& mesh) {
  ImageFiles files{reader.textures(), {}};
  ImageNames names(mesh);
  files.has_alpha.resize(files.set.textures.size());
  for (size_t i = 0; i < files.set.textures.size(); ++i) {
    Texture& texture = files.set.textures[i];
    if (texture.name.empty()) texture.name = "missing";
    if (texture.tiles.empty()) continue;
    const std::string name = names.next(texture.name);
    files.has_alpha[i] = exportImage(reader, texture, mesh.parent_path() / name);
    texture.name = name;
  }
  return files;
}

}  // namespace lode::store
