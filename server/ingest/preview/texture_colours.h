#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "common/image/image.h"
#include "server/ingest/soup/uv_grid.h"
#include "server/ingest/textures/texture_images.h"

namespace lode::ingest {

/// A model's images at a low resolution, from which a preview takes its colours.
class TextureColours {
 public:
  /// Largest edge of an image that is kept.
  static constexpr uint32_t kMostEdgePx = 256;
  /// Largest number of decoded pixels of all images together. Further images are left out, because decoding
  /// them would delay the preview. For a JPEG, only the pixels that its decoder computes count.
  static constexpr uint64_t kMostPixels = 48u << 20;

  TextureColours() = default;  ///< no images
  /// Decodes images, one at a time. Leaves out images with a problem; the build warns of them.
  /// @param image_bytes  limit per image (MemoryPlan).
  TextureColours(std::span<const TextureImage> images, const UvGrid& grid, uint64_t image_bytes);

  /// Returns true if there is no image to take colours from.
  bool empty() const noexcept { return images_.empty(); }
  /// Returns the colour of an image at a texture coordinate, without alpha; white if the image is left out.
  glm::u8vec3 at(uint16_t material, glm::u16vec2 texture) const noexcept;

 private:
  std::vector<Image> images_;  ///< indexed by material; empty images are left out
  glm::dvec2 origin_{0};
  double step_ = 1;  ///< texture coordinate is origin_ + code * step_
};

}  // namespace lode::ingest
