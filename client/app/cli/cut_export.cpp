#include "client/app/cli/cut_export.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <glm/glm.hpp>

#include "common/image/tile_image.h"
#include "common/io/mesh_joiner.h"
#include "common/io/mesh_materials.h"
#include "common/io/output_target.h"
#include "common/mesh_images/image_names.h"
#include "common/mesh_images/png_writer.h"

namespace lode::app {

CutImages writeCutImages(const core::Cut& cut, const Mesh& mesh, const std::filesystem::path& mesh_file) {
  CutImages images;
  if (!cut.textures || cut.textures->textures.empty()) return images;
  refuseFilesBesideStream(mesh_file);
  TextureSet& set = images.files.set;
  set = *cut.textures;
  ImageNames names(mesh_file);
  std::vector<bool> is_written(set.textures.size());
  images.files.has_alpha.resize(set.textures.size());
  for (const MaterialGroup& group : groupByMaterial(mesh)) {
    if (imageOf(mesh, set, group.material).empty()) continue;
    Texture& texture = set.textures[group.material];
    const ResidentImage image(cut.textures->textures[group.material], group.material, cut.tiles);
    if (!image.isComplete()) {
      images.left_out.push_back(texture.name);
      continue;
    }
    const std::string name = names.next(texture.name);
    const bool has_alpha = image.hasAlpha();
    images.files.written.push_back(mesh_file.parent_path() / name);
    const auto fill = [&](uint32_t y, std::span<glm::u8vec4> row) { image.fill(y, row); };
    writePng(images.files.written.back(), image.size(), has_alpha, fill, OutputName::kDerived);
    texture.name = name;
    is_written[group.material] = true;
    images.files.has_alpha[group.material] = has_alpha;
  }
  for (size_t i = 0; i < is_written.size(); ++i)
    if (!is_written[i]) set.textures[i].width = set.textures[i].height = 0;
  return images;
}

Mesh weldCut(const core::Cut& cut, AttributeSet attributes) {
  MeshJoiner joiner(attributes, cut.triangles);
  for (const core::CutPart& part : cut.parts) joiner.add(*part.mesh);
  return joiner.finish();
}

ResidentImage::ResidentImage(const Texture& texture, uint32_t number,
                             std::span<const core::ResidentTile> tiles)
    : texture_(texture), levels_(levelCount(texture)) {
  for (uint32_t level = 0; level < levels_.size(); ++level) {
    levels_[level].across = tilesAcross(texture, level);
    levels_[level].tiles.resize(size_t{levels_[level].across} * tilesDown(texture, level));
  }
  finest_ = levels_.empty() ? 0 : static_cast<uint32_t>(levels_.size() - 1);
  for (const auto& [key, image] : tiles) {
    if (key.texture != number) continue;
    levels_[key.level].tiles[size_t{key.y} * levels_[key.level].across + key.x] = image.get();
    finest_ = std::min(finest_, key.level);
  }
}

bool ResidentImage::isComplete() const noexcept {
  return !levels_.empty() && levels_.back().tiles[0] != nullptr;
}

bool ResidentImage::hasAlpha() const {
  const auto isClear = [](const glm::u8vec4& texel) { return texel.a != 255; };
  const auto hasClear = [&](const TileImage* tile) {
    return tile != nullptr && std::ranges::any_of(tile->texels, isClear);
  };
  return std::ranges::any_of(levels_,
                             [&](const Level& level) { return std::ranges::any_of(level.tiles, hasClear); });
}

void ResidentImage::fill(uint32_t y, std::span<glm::u8vec4> row) const { fill(finest_, y, 0, size().x, row); }

/// Fills the range [first, end) of a row from the tiles of a level. Where a tile is missing, uses coarser
/// levels. `y`, `first` and `end` are in texels of the image.
void ResidentImage::fill(uint32_t level, uint32_t y, uint32_t first, uint32_t end,
                         std::span<glm::u8vec4> row) const {
  const uint32_t shift = level - finest_;
  const uint32_t level_y = y >> shift;
  for (uint32_t x = first; x < end;) {
    const uint32_t column = (x >> shift) / kTileInnerPx;
    const uint32_t next = std::min(end, ((column + 1) * kTileInnerPx) << shift);
    const TileImage* const tile =
        levels_[level].tiles[size_t{level_y / kTileInnerPx} * levels_[level].across + column];
    if (tile == nullptr) {
      fill(level + 1, y, x, next, row);
    } else {
      const glm::u8vec4* const from =
          &tile->texels[size_t{level_y % kTileInnerPx + kTileGutterPx} * tile->size.x + kTileGutterPx];
      for (uint32_t to = x; to < next; ++to) row[to] = from[(to >> shift) - column * kTileInnerPx];
    }
    x = next;
  }
}

}  // namespace lode::app
