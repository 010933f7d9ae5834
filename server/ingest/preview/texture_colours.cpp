#include "server/ingest/preview/texture_colours.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/error.h"
#include "server/ingest/textures/image_decoder.h"

namespace lode::ingest {
namespace {

/// Returns the index of the texel at a coordinate of an image that repeats.
uint32_t texelAt(double coordinate, uint32_t size) noexcept {
  const double within = coordinate - std::floor(coordinate);
  return std::min(static_cast<uint32_t>(within * size), size - 1);
}

}  // namespace

TextureColours::TextureColours(std::span<const TextureImage> images, const UvGrid& grid, uint64_t image_bytes)
    : origin_(grid.origin), step_(std::ldexp(1.0, grid.scale_exponent - 16)) {
  uint64_t pixels = 0;
  for (size_t number = 0; number < images.size(); ++number) {
    const TextureImage& image = images[number];
    if (!image.problem.empty()) continue;
    try {
      const std::vector<std::byte> file = readImageFile(image.path, image_bytes);
      pixels += coarsePixels(file);
      if (pixels > kMostPixels) return;
      Image coarse = decodeCoarsely(file, image_bytes);
      while (std::max(coarse.size.x, coarse.size.y) > kMostEdgePx) coarse = halved(coarse);
      images_.resize(number + 1);
      images_[number] = std::move(coarse);
    } catch (const Error&) {  // ignored: the build warns about the image
    }
  }
}

glm::u8vec3 TextureColours::at(uint16_t material, glm::u16vec2 texture) const noexcept {
  if (material >= images_.size() || images_[material].texels.empty()) return glm::u8vec3(255);
  const Image& image = images_[material];
  const glm::dvec2 uv = origin_ + glm::dvec2(texture) * step_;
  return image.at(texelAt(uv.x, image.size.x), texelAt(1 - uv.y, image.size.y));
}

}  // namespace lode::ingest
