#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <tuple>

#include <glm/glm.hpp>

#include "common/codec/texture_set.h"

namespace lode::render {

/// A square of one layer of the texture array.
struct TileCell {
  uint32_t layer = 0;
  glm::uvec2 corner{0};  ///< texels, a multiple of the edge
  uint32_t edge = 0;     ///< texels, a power of two from kLeastTileCellPx to kTilePx
};

/// Hands out squares of layers of kTilePx texels: each layer is a quadtree whose free squares are split and
/// joined by four (buddy allocation; Knowlton, A Fast Storage Allocator, 1965). The lowest layer with the
/// tightest free square is taken. Pure bookkeeping. Not thread safe.
class TileCells {
 public:
  /// @param most_layers  that may be used.
  explicit TileCells(uint32_t most_layers) : most_layers_(most_layers) {}

  /// @param size  of an image, at most kTilePx each way. @return nothing if there is no room.
  std::optional<TileCell> allocate(glm::uvec2 size);
  /// @param cell  as allocate() gave it.
  void release(const TileCell& cell);
  /// More than before.
  void allow(uint32_t most_layers) noexcept { most_layers_ = most_layers; }
  /// Layers that were ever in use.
  uint32_t layers() const noexcept { return layers_; }

 private:
  static constexpr uint32_t kOrders = 5;  // edges of 512, 256, 128, 64 and 32 texels
  static constexpr uint32_t edgeOf(uint32_t order) noexcept { return kTilePx >> order; }
  using Place = std::tuple<uint32_t, uint32_t, uint32_t>;  // layer, y, x

  std::array<std::set<Place>, kOrders> free_;
  uint32_t layers_ = 0, most_layers_;
};

}  // namespace lode::render
