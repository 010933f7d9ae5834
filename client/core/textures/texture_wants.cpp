#include "client/core/textures/texture_wants.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "client/core/textures/tile.h"

namespace lode::core {
namespace {

/// Demand for one level 0 tile, combined over all parts that use the tile.
struct Demand {
  double texels_px = std::numeric_limits<double>::infinity();  // level 0 texels per pixel, the smallest over
                                                               // all parts
  bool visible = false;
};

using Demands = std::vector<Demand>;  // indexed by y * tilesAcross + x of level 0

double pixelModel(double distance_model, const View& view) {
  const double distance = std::max(distance_model, view.near_model);
  return distance * 2 * std::tan(view.fov_y_rad / 2) / view.height_px;
}

/// Returns the first and last tile of a coarser level that overlap a level 0 tile, along one axis.
glm::uvec2 coarserTiles(uint32_t tile, uint32_t size, uint32_t coarse_size, uint32_t coarse_tiles) {
  const uint64_t first = uint64_t{tile} * kTileInnerPx * coarse_size / size;
  const uint64_t end = std::min<uint64_t>(uint64_t{tile + 1} * kTileInnerPx, size) * coarse_size;
  const uint64_t last = (end + size - 1) / size - 1;
  return {static_cast<uint32_t>(first / kTileInnerPx),
          std::min(static_cast<uint32_t>(last / kTileInnerPx), coarse_tiles - 1)};
}

/// Demand for the tiles of one texture.
class TextureDemand {
 public:
  TextureDemand(const Texture& texture, uint32_t number)
      : texture_(texture), number_(number), levels_(levelCount(texture)), across_(tilesAcross(texture, 0)) {
    demands_.resize(size_t{across_} * tilesDown(texture, 0));
  }

  void add(const TouchedTile& tile, double pixel_model, bool visible) {
    raise(demands_[size_t{tile.y} * across_ + tile.x],
          demandFor(tile.texels_per_model, pixel_model, visible));
  }
  void addWhole(float texels_per_model, double pixel_model, bool visible) {
    raise(whole_, demandFor(texels_per_model, pixel_model, visible));
  }
  /// Applies the demands passed to addWhole() to all tiles. Call spreadWhole() after adding all demands.
  void spreadWhole() {
    for (Demand& demand : demands_) raise(demand, whole_);
  }

  void appendTo(std::vector<WantedTile>& wanted, double threshold_px, double most_px) const {
    for (uint32_t level = 0; level < levels_; ++level) appendLevel(wanted, level, threshold_px, most_px);
  }

 private:
  static Demand demandFor(float texels_per_model, double pixel_model, bool visible) {
    return {std::max(double{texels_per_model} * pixel_model, 1e-9), visible};
  }

  static void raise(Demand& demand, const Demand& other) {
    if (demand.visible == other.visible) {
      demand.texels_px = std::min(demand.texels_px, other.texels_px);
    } else if (other.visible) {
      demand = other;
    }
  }

  uint32_t neededLevel(const Demand& demand, double threshold_px) const {
    const double level = std::floor(std::log2(std::max(demand.texels_px * threshold_px, 1.0)));
    return std::min(static_cast<uint32_t>(std::min(level, 64.0)), levels_ - 1);
  }

  void appendLevel(std::vector<WantedTile>& wanted, uint32_t level, double threshold_px,
                   double most_px) const {
    const bool coarsest = level + 1 == levels_;
    const glm::uvec2 size = levelSize(texture_, 0), level_size = levelSize(texture_, level);
    const glm::uvec2 tiles(tilesAcross(texture_, level), tilesDown(texture_, level));
    const double covered =
        coarsest ? std::max(texture_.width, texture_.height) : std::ldexp(1.0, static_cast<int>(level) + 1);
    std::vector<WantedTile> here(size_t{tiles.x} * tiles.y);  // tiles with priority 0 are not wanted
    for (uint32_t i = 0; i < demands_.size(); ++i) {
      const Demand& demand = demands_[i];
      if (std::isinf(demand.texels_px)) continue;
      if (!coarsest && (!demand.visible || neededLevel(demand, threshold_px) > level)) continue;
      const glm::uvec2 x = coarserTiles(i % across_, size.x, level_size.x, tiles.x);
      const glm::uvec2 y = coarserTiles(i / across_, size.y, level_size.y, tiles.y);
      const auto priority_px = static_cast<float>(std::min(covered / demand.texels_px, most_px));
      for (uint32_t row = y[0]; row <= y[1]; ++row)
        for (uint32_t column = x[0]; column <= x[1]; ++column) {
          WantedTile& tile = here[size_t{row} * tiles.x + column];
          const bool is_new = tile.priority_px == 0;
          if (!is_new && tile.visible && !demand.visible) continue;
          const float before_px = is_new || tile.visible != demand.visible ? 0 : tile.priority_px;
          tile = {{level, number_, row, column}, demand.visible, std::max(before_px, priority_px)};
        }
    }
    std::copy_if(here.begin(), here.end(), std::back_inserter(wanted),
                 [](const WantedTile& tile) { return tile.priority_px > 0; });
  }

  const Texture& texture_;
  uint32_t number_, levels_, across_;
  Demands demands_;
  Demand whole_;  // demand of the parts that use the whole texture
};

}  // namespace

uint64_t tileRoomBytes(glm::uvec2 image_size) noexcept {
  const uint64_t edge = std::bit_ceil(std::max({image_size.x, image_size.y, kLeastTileCellPx}));
  return edge * edge * sizeof(glm::u8vec4);
}

uint64_t tileRoomBytes(const TextureSet& set, const TileKey& key) {
  const glm::uvec2 size = tileImageSize(set, key);
  uint64_t bytes = tileRoomBytes(size);
  if (key.level + 1 < levelCount(set.textures[key.texture])) return bytes;
  for (const glm::uvec2 coarser : tailSizes(size)) bytes += tileRoomBytes(coarser);
  return bytes;
}

uint64_t tileRoomBytes(const TileImage& image) noexcept {
  uint64_t bytes = tileRoomBytes(image.size);
  for (const TileImage& coarser : image.coarser) bytes += tileRoomBytes(coarser.size);
  return bytes;
}

std::vector<WantedTile> wantTiles(const TextureSet& set, std::span<const TexturedPart> parts,
                                  const View& view, float threshold_px) {
  std::map<uint32_t, TextureDemand> textures;
  const auto demandOf = [&](uint32_t number) {
    return &textures.try_emplace(number, set.textures[number], number).first->second;
  };
  for (const TexturedPart& part : parts) {
    const double pixel_model = pixelModel(part.distance_model, view);
    TextureDemand* texture = nullptr;
    uint32_t number = 0;
    for (const TouchedTile& tile : part.footprint->tiles) {
      if (texture == nullptr || number != tile.texture) {
        number = tile.texture;
        texture = demandOf(number);
      }
      texture->add(tile, pixel_model, part.visible);
    }
    for (const WornTexture& worn : part.footprint->whole)
      demandOf(worn.texture)->addWhole(worn.texels_per_model, pixel_model, part.visible);
  }
  std::vector<WantedTile> wanted;
  for (auto& [number, texture] : textures) {
    texture.spreadWhole();
    texture.appendTo(wanted, std::max(threshold_px, 1.0f), std::max(view.width_px, view.height_px));
  }
  const auto coarsest = [&](const WantedTile& tile) {
    return tile.key.level + 1 == levelCount(set.textures[tile.key.texture]);
  };
  std::sort(wanted.begin(), wanted.end(), [&](const WantedTile& a, const WantedTile& b) {
    if (coarsest(a) != coarsest(b)) return coarsest(a);
    if (a.visible != b.visible) return a.visible;
    if (a.priority_px != b.priority_px) return a.priority_px > b.priority_px;
    return a.key < b.key;
  });
  return wanted;
}

size_t countFitting(const TextureSet& set, std::span<const WantedTile> wanted, uint64_t budget_bytes) {
  uint64_t room_bytes = 0;
  for (size_t i = 0; i < wanted.size(); ++i) {
    room_bytes += tileRoomBytes(set, wanted[i].key);
    if (room_bytes > budget_bytes) return i;
  }
  return wanted.size();
}

}  // namespace lode::core
