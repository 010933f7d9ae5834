#include "server/store/export.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "common/codec/draco_codec.h"
#include "common/error.h"
#include "common/image/tile_image.h"
#include "common/io/mesh_file.h"
#include "common/io/mesh_joiner.h"
#include "common/mesh_images/image_names.h"
#include "common/mesh_images/png_writer.h"

namespace lode::store {
namespace {

/// Reads the tiles of a texture's finest level, level 0.
class FinestTiles {
 public:
  FinestTiles(const Reader& reader, const Texture& texture) : reader_(reader), texture_(texture) {}

  glm::uvec2 count() const { return {tilesAcross(texture_, 0), tilesDown(texture_, 0)}; }
  std::vector<std::byte> file(uint32_t x, uint32_t y) const {
    return reader_.readBlob(texture_.tiles[tileIndex(texture_, 0, x, y)].number);
  }
  TileImage image(uint32_t x, uint32_t y) const {
    return decodeTile(file(x, y), tileInnerSize(texture_, 0, x, y) + 2 * kTileGutterPx);
  }
  /// Returns true if any texel is not opaque. Decodes each tile with an alpha channel, because its texels can
  /// still be opaque.
  bool haveClearTexels() const {
    const auto isClear = [](const glm::u8vec4& texel) { return texel.a != 255; };
    for (uint32_t y = 0; y < count().y; ++y)
      for (uint32_t x = 0; x < count().x; ++x)
        if (tileMayBeClear(file(x, y)) && std::ranges::any_of(image(x, y).texels, isClear)) return true;
    return false;
  }

 private:
  const Reader& reader_;
  const Texture& texture_;
};

/// Writes one texture as a PNG file. @return true if the image has alpha.
bool exportImage(const Reader& reader, const Texture& texture, const std::filesystem::path& path) {
  const FinestTiles stored(reader, texture);
  const bool has_alpha = stored.haveClearTexels();
  std::vector<TileImage> tiles(stored.count().x);
  const auto fill = [&](uint32_t y, std::span<glm::u8vec4> row) {
    const uint32_t line = y % kTileInnerPx;
    if (line == 0)
      for (uint32_t x = 0; x < tiles.size(); ++x) tiles[x] = stored.image(x, y / kTileInnerPx);
    auto to = row.begin();
    for (const TileImage& tile : tiles) {
      const auto* const from = tile.texels.data() + size_t{line + kTileGutterPx} * tile.size.x;
      to = std::copy(from + kTileGutterPx, from + tile.size.x - kTileGutterPx, to);
    }
  };
  writePng(path, {texture.width, texture.height}, has_alpha, fill, OutputName::kDerived);
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
    files.written.push_back(mesh.parent_path() / name);
    files.has_alpha[i] = exportImage(reader, texture, files.written.back());
    texture.name = name;
  }
  return files;
}

DecodedLod decodeLod(const Reader& reader, const Node& node, uint32_t lod_number) {
  const Lod& lod = node.lods[lod_number];
  DecodedLod decoded;
  decoded.mesh.attributes = reader.summary().attributes;
  if (!lod.payload) return decoded;
  decoded.payload = reader.readBlob(lod.payload.number);
  const PayloadExpectation expected{.triangles = lod.triangles,
                                    .vertices = lod.vertices,
                                    .attributes = reader.summary().attributes,
                                    .box = node.box};
  try {
    decoded.mesh = decodePayload(decoded.payload, reader.summary().lattice.step, expected, &decoded.ids);
    return decoded;
  } catch (const Error& error) {
    throw Error(error.code(), reader.path().string() + ": node " + describeKey(node.key) + ", LOD " +
                                  std::to_string(lod_number) + ": " + error.what());
  }
}

Mesh readLod(const Reader& reader, const Node& node, uint32_t lod) {
  return decodeLod(reader, node, lod).mesh;
}

Mesh assembleCut(const Reader& reader, const Cut& cut) {
  MeshJoiner joiner(reader.summary().attributes, cut.triangles);
  for (const CutItem item : cut.items) joiner.add(readLod(reader, reader.nodes()[item.node], item.lod));
  return joiner.finish();
}

std::vector<std::filesystem::path> exportCut(const Reader& reader, const Cut& cut,
                                             const std::filesystem::path& path) {
  const Mesh mesh = assembleCut(reader, cut);
  return writeMesh(path, mesh, reader.summary().lattice, exportTextures(reader, path));
}

}  // namespace lode::store
