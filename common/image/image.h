#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace lode {

/// A picture in memory: texels by rows from the top, sRGB with straight alpha.
struct Image {
  glm::uvec2 size{0};
  std::vector<glm::u8vec4> texels;

  bool operator==(const Image&) const = default;
  const glm::u8vec4& at(uint32_t x, uint32_t y) const { return texels[size_t{y} * size.x + x]; }
};

/// The next coarser level of a picture: of ceil(size / 2) texels each way, each the mean of what it covers,
/// in linear light, colours weighted by their alpha. Thread safe.
Image halved(const Image& image);

/// A part of a picture that goes on beyond its rims by repetition. Thread safe.
Image cutOut(const Image& image, glm::ivec2 first, glm::uvec2 size);

}  // namespace lode
