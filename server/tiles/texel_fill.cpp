#include "server/tiles/texel_fill.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace lode::tiles {
namespace {

/// Returns the next coarser level of the pyramid: mean colours of the known texels; alpha is 0 where no texel
/// is known.
Image pull(const Image& finer) {
  Image coarser{(finer.size + 1u) / 2u, {}};
  coarser.texels.resize(size_t{coarser.size.x} * coarser.size.y);
  for (uint32_t y = 0; y < coarser.size.y; ++y)
    for (uint32_t x = 0; x < coarser.size.x; ++x) {
      glm::uvec3 sum(0);
      uint32_t count = 0;
      for (uint32_t j = 2 * y; j < std::min(2 * y + 2, finer.size.y); ++j)
        for (uint32_t i = 2 * x; i < std::min(2 * x + 2, finer.size.x); ++i) {
          const glm::u8vec4 texel = finer.at(i, j);
          if (texel.a == 0) continue;
          sum += glm::uvec3(texel);
          ++count;
        }
      if (count > 0)
        coarser.texels[size_t{y} * coarser.size.x + x] = glm::u8vec4(glm::u8vec3(sum / count), 255);
    }
  return coarser;
}

}  // namespace

void fillUnknown(Image& image, const std::vector<bool>& is_known) {
  if (std::ranges::find(is_known, false) == is_known.end()) return;
  std::vector<Image> levels{image};
  for (size_t i = 0; i < is_known.size(); ++i) levels[0].texels[i].a = is_known[i] ? 255 : 0;
  while (levels.back().size != glm::uvec2(1)) levels.push_back(pull(levels.back()));
  for (size_t level = levels.size() - 1; level-- > 0;) {
    Image& finer = levels[level];
    const Image& coarser = levels[level + 1];
    for (uint32_t y = 0; y < finer.size.y; ++y)
      for (uint32_t x = 0; x < finer.size.x; ++x) {
        glm::u8vec4& texel = finer.texels[size_t{y} * finer.size.x + x];
        if (texel.a == 0) texel = coarser.at(x / 2, y / 2);
      }
  }
  for (size_t i = 0; i < is_known.size(); ++i)
    if (!is_known[i]) image.texels[i] = glm::u8vec4(glm::u8vec3(levels[0].texels[i]), image.texels[i].a);
}

}  // namespace lode::tiles
