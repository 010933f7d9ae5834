#include "client/core/tile_tail.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/texture_set.h"

namespace lode::core {
namespace {

glm::uvec2 innerSize(glm::uvec2 image_size) { return image_size - 2 * kTileGutterPx; }

float toLinear(uint8_t byte) {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> linear;
    for (int i = 0; i < 256; ++i) {
      const double srgb = i / 255.0;
      linear[i] = static_cast<float>(srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4));
    }
    return linear;
  }();
  return table[byte];
}

uint8_t toSrgb(float linear) {
  const float srgb = linear <= 0.0031308f ? linear * 12.92f : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
  return static_cast<uint8_t>(std::lround(255 * std::clamp(srgb, 0.0f, 1.0f)));
}

/// Mean of the texels that a texel of half the size covers.
glm::u8vec4 meanAt(const TileImage& image, glm::uvec2 at) {
  const glm::uvec2 first = 2u * at, last = glm::min(first + 1u, innerSize(image.size) - 1u);
  glm::vec3 weighted(0), plain(0);
  float alpha = 0, count = 0;
  for (uint32_t y = first.y; y <= last.y; ++y)
    for (uint32_t x = first.x; x <= last.x; ++x) {
      const glm::u8vec4 texel = image.texels[(y + kTileGutterPx) * image.size.x + x + kTileGutterPx];
      const glm::vec3 colour(toLinear(texel.r), toLinear(texel.g), toLinear(texel.b));
      weighted += colour * static_cast<float>(texel.a);
      plain += colour;
      alpha += texel.a;
      ++count;
    }
  const glm::vec3 mean = alpha > 0 ? weighted / alpha : plain / count;
  return {toSrgb(mean.r), toSrgb(mean.g), toSrgb(mean.b), static_cast<uint8_t>(std::lround(alpha / count))};
}

TileImage halved(const TileImage& image) {
  const glm::uvec2 inner = (innerSize(image.size) + 1u) / 2u;
  TileImage result{inner + 2 * kTileGutterPx, {}, {}};
  result.texels.resize(size_t{result.size.x} * result.size.y);
  const auto at = [&](glm::uvec2 place) -> glm::u8vec4& {
    return result.texels[size_t{place.y} * result.size.x + place.x];
  };
  for (uint32_t y = 0; y < inner.y; ++y)
    for (uint32_t x = 0; x < inner.x; ++x) at(glm::uvec2(x, y) + kTileGutterPx) = meanAt(image, {x, y});
  for (uint32_t y = 0; y < result.size.y; ++y)  // the gutters repeat the image
    for (uint32_t x = 0; x < result.size.x; ++x) {
      const glm::uvec2 within = (glm::uvec2(x, y) + inner * kTileGutterPx - kTileGutterPx) % inner;
      at({x, y}) = at(within + kTileGutterPx);
    }
  return result;
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
  coarsest.coarser.clear();
  std::vector<TileImage> tail;
  for (size_t levels = tailSizes(coarsest.size).size(); tail.size() < levels;)
    tail.push_back(halved(tail.empty() ? coarsest : tail.back()));
  coarsest.coarser = std::move(tail);
}

}  // namespace lode::core
