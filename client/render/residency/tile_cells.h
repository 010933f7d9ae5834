#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <tuple>

#include <glm/glm.hpp>

#include "common/codec/texture_set.h"

namespace lode::render {

/// A square in a layer of the texture array.
struct TileCell {
  uint32_t layer = 0;
  glm::uvec2 corner{0};  ///< top left corner in texels, a multiple of the edge
  uint32_t edge = 0;     ///< edge in texels, a power of two from kLeastTileCellPx to kTilePx
};

/// Allocates squares in layers of kTilePx × kTilePx texels. Each layer is a quadtree: a free square splits
/// into four, and four free squares join again (buddy allocation; Knowlton, A Fast Storage Allocator, 1965).
/// Allocates the smallest free square that fits; among equal squares, the one in the layer with the smallest
/// index. Uses no OpenGL. Not thread safe.
class TileCells {
 public:
  /// @param most_layers  largest number of layers to use.
  explicit TileCells(uint32_t most_layers) : most_layers_(most_layers) {}

  /// @param size  size of an image, at most kTilePx per side. @return nothing if there is no room.
  std::optional<TileCell> allocate(glm::uvec2 size);
  /// @param cell  cell that allocate() returned.
  void release(const TileCell& cell);
  /// Changes the limit of the number of layers.
  void allow(uint32_t most_layers) noexcept { most_layers_ = most_layers; }
  /// Returns the peak number of layers in use.
  uint32_t layers() const noexcept { return layers_; }

 private:
  static constexpr uint32_t kOrders = 5;  // number of square sizes: 512, 256, 128, 64 and 32 texels
  static constexpr uint32_t edgeOf(uint32_t order) noexcept { return kTilePx >> order; }
  using Place = std::tuple<uint32_t, uint32_t, uint32_t>;  // layer, y, x

  std::array<std::set<Place>, kOrders> free_;
  uint32_t layers_ = 0, most_layers_;
};

}  // namespace lode::render
