#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <tuple>
#include <vector>

#include <webp/encode.h>

#include "common/codec/texture_set.h"
#include "common/image/tile_image.h"

/// Textures for the tests of all modules that read them.
namespace lode::test {

/// A function that returns the colour of a texel of level 0, counted from the top left.
using TexelFunction = std::function<glm::u8vec4(uint32_t x, uint32_t y)>;

/// The levels of an image, made by averaging 2 x 2 texels in linear light, as the format requires. Returns
/// tiles by level, x and y.
class TextureImages {
 public:
  TextureImages(uint32_t width, uint32_t height, const TexelFunction& texel) {
    texture_.name = "made.png";
    texture_.width = width;
    texture_.height = height;
    texture_.tiles.resize(tileCount(texture_));
    std::vector<glm::u8vec4>& finest = levels_.emplace_back();
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) finest.push_back(texel(x, y));
    for (uint32_t level = 1; level < levelCount(texture_); ++level) halve(level);
  }

  Texture& texture() { return texture_; }
  const Texture& texture() const { return texture_; }

  TileImage tile(uint32_t level, uint32_t x, uint32_t y) const {
    const glm::uvec2 size = tileInnerSize(texture_, level, x, y) + 2 * kTileGutterPx;
    const glm::uvec2 whole = levelSize(texture_, level);
    TileImage image{size, {}, {}};
    for (uint32_t row = 0; row < size.y; ++row)
      for (uint32_t column = 0; column < size.x; ++column) {
        const uint32_t from_x =
            (x * kTileInnerPx + column + whole.x * kTileGutterPx - kTileGutterPx) % whole.x;
        const uint32_t from_y = (y * kTileInnerPx + row + whole.y * kTileGutterPx - kTileGutterPx) % whole.y;
        image.texels.push_back(levels_[level][size_t{from_y} * whole.x + from_x]);
      }
    return image;
  }

  /// Calls use(level, x, y) in the order of Texture::tiles.
  template <typename Use>
  void forEachTile(Use&& use) const {
    for (uint32_t level = levelCount(texture_); level-- > 0;)
      for (uint32_t y = 0; y < tilesDown(texture_, level); ++y)
        for (uint32_t x = 0; x < tilesAcross(texture_, level); ++x) use(level, x, y);
  }

 private:
  void halve(uint32_t level) {
    const glm::uvec2 from = levelSize(texture_, level - 1), to = levelSize(texture_, level);
    const std::vector<glm::u8vec4>& finer = levels_.back();
    std::vector<glm::u8vec4> coarser;
    for (uint32_t y = 0; y < to.y; ++y)
      for (uint32_t x = 0; x < to.x; ++x) {
        glm::dvec4 sum(0);
        for (const glm::uvec2 corner : {glm::uvec2(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
          const glm::uvec2 at = glm::min(2u * glm::uvec2(x, y) + corner, from - 1u);
          for (int channel = 0; channel < 4; ++channel)
            sum[channel] +=
                std::pow(finer[size_t{at.y} * from.x + at.x][channel] / 255.0, channel < 3 ? 2.2 : 1.0);
        }
        glm::u8vec4 mean;
        for (int channel = 0; channel < 4; ++channel)
          mean[channel] = static_cast<uint8_t>(
              std::lround(255 * std::pow(sum[channel] / 4, channel < 3 ? 1 / 2.2 : 1.0)));
        coarser.push_back(mean);
      }
    levels_.push_back(std::move(coarser));
  }

  Texture texture_;
  std::vector<std::vector<glm::u8vec4>> levels_;
};

/// Returns an image as a lossless WebP file.
inline std::vector<std::byte> webpOf(const TileImage& image) {
  uint8_t* file = nullptr;
  const size_t bytes = WebPEncodeLosslessRGBA(reinterpret_cast<const uint8_t*>(image.texels.data()),
                                              static_cast<int>(image.size.x), static_cast<int>(image.size.y),
                                              static_cast<int>(image.size.x * sizeof(glm::u8vec4)), &file);
  const auto* const begin = reinterpret_cast<const std::byte*>(file);
  std::vector<std::byte> result(begin, begin + bytes);
  WebPFree(file);
  return result;
}

}  // namespace lode::test
