#include "client/core/textures/tile.h"

#include <algorithm>
#include <utility>

#include "common/codec/texture_set.h"
#include "common/image/image.h"

namespace lode::core {
namespace {

glm::uvec2 innerSize(glm::uvec2 image_size) { return image_size - 2 * kTileGutterPx; }

TileImage withGutters(const Image& inner) {
  const glm::uvec2 size = inner.size + 2 * kTileGutterPx;
  return {size, cutOut(inner, glm::ivec2(-int{kTileGutterPx}), size).texels, {}};
}

}  // namespace

std::vector<glm::uvec2> tailSizes(glm::uvec2 coarsest) {
  std::vector<glm::uvec2> sizes;
  for (glm::uvec2 inner = innerSize(coarsest); std::max(inner.x, inner.y) > 1;) {
    inner = (inner + 1u) / 2u;
    sizes.push_back(inner + 2 * kTileGutterPx);
  }
  return sizes;
}

void makeTail(TileImage& coarsest) {
  Image level = cutOut({coarsest.size, coarsest.texels}, glm::ivec2(kTileGutterPx), innerSize(coarsest.size));
  std::vector<TileImage> tail;
  for (size_t levels = tailSizes(coarsest.size).size(); tail.size() < levels;) {
    level = halved(level);
    tail.push_back(withGutters(level));
  }
  coarsest.coarser = std::move(tail);
}

}  // namespace lode::core
