#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/lod/cut.h"
#include "common/codec/texture_set.h"

namespace lode::app {

/// The image of a texture as far as its tiles are resident: of the finest level that any of them has, and
/// where that level lacks a tile, the texels of the next coarser one that does not, each as often as needed.
class ResidentImage {
 public:
  /// @param tiles  of this texture and others; they and the texture outlive this.
  ResidentImage(const Texture& texture, uint32_t number, std::span<const core::ResidentTile> tiles);

  /// Its coarsest level is there, so that every texel has a colour; nothing else may be called otherwise.
  bool isThere() const noexcept;
  glm::uvec2 size() const { return levelSize(texture_, finest_); }
  /// Some texel is not opaque.
  bool hasAlpha() const;
  /// @param row  of the image's width; y counts from the top.
  void fill(uint32_t y, std::span<glm::u8vec4> row) const;

 private:
  struct Level {
    uint32_t across = 0;
    std::vector<const TileImage*> tiles;  // null where one is not resident
  };
  void fill(uint32_t level, uint32_t y, uint32_t first, uint32_t end, std::span<glm::u8vec4> row) const;

  const Texture& texture_;
  std::vector<Level> levels_;
  uint32_t finest_ = 0;
};

}  // namespace lode::app
