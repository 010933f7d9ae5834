#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace lode {

/// An image in memory, with rows from the top and sRGB texels with straight alpha.
struct Image {
  glm::uvec2 size{0};
  std::vector<glm::u8vec4> texels;

  bool operator==(const Image&) const = default;
  const glm::u8vec4& at(uint32_t x, uint32_t y) const { return texels[size_t{y} * size.x + x]; }
};

/// Returns the next coarser level of an image, with ceil(size / 2) texels along each axis. Each texel is the
/// mean of the finer texels that it covers. The mean is taken in linear light and weighted by alpha. Thread
/// safe.
Image halved(const Image& image);

/// Returns a part of an image that begins at texel `first`. The image repeats beyond its edges, so `first`
/// may be negative. Thread safe.
Image cutOut(const Image& image, glm::ivec2 first, glm::uvec2 size);

/// Returns the linear light, 0 to 1, of an sRGB byte (IEC 61966-2-1).
double linearOf(uint8_t srgb) noexcept;
/// Returns the nearest sRGB byte. @param linear  clamped to 0..1.
uint8_t srgbOf(double linear) noexcept;

}  // namespace lode
