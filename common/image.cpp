#include "common/image.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lode {
namespace {

constexpr int kLinearSteps = 65536;

/// Between sRGB bytes and 16 bits of linear light.
class LightTables {
 public:
  static const LightTables& get() {
    static const LightTables tables;
    return tables;
  }
  uint64_t linear(uint8_t srgb) const noexcept { return linear_[srgb]; }
  uint8_t srgb(uint64_t linear) const noexcept { return srgb_[linear]; }

 private:
  LightTables() : srgb_(kLinearSteps) {
    for (int i = 0; i < 256; ++i) {
      const double s = i / 255.0;
      const double light = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
      linear_[static_cast<size_t>(i)] = static_cast<uint16_t>(std::lround(light * (kLinearSteps - 1)));
    }
    size_t value = 0;
    for (size_t i = 0; i < srgb_.size(); ++i) {
      while (value < 255 && 2 * i >= size_t{linear_[value]} + linear_[value + 1]) ++value;
      srgb_[i] = static_cast<uint8_t>(value);
    }
  }

  std::array<uint16_t, 256> linear_{};
  std::vector<uint8_t> srgb_;
};

/// Which texels of a row or column a coarser one covers, and how much of each.
struct Cover {
  uint32_t first = 0, count = 0;
  std::array<uint32_t, 3> weights{};  ///< sum: the finer level's texels
};

std::vector<Cover> coversOf(uint32_t from, uint32_t to) {
  std::vector<Cover> covers(to);
  for (uint64_t i = 0; i < to; ++i) {
    const uint64_t begin = i * from, end = begin + from;  // in parts of 1 / to of a finer texel
    Cover& cover = covers[i];
    cover.first = static_cast<uint32_t>(begin / to);
    for (uint64_t j = cover.first; j * to < end; ++j)
      cover.weights[cover.count++] =
          static_cast<uint32_t>(std::min(end, (j + 1) * to) - std::max(begin, j * to));
  }
  return covers;
}

glm::u8vec4 meanOf(const Image& image, const Cover& across, const Cover& down) {
  const LightTables& light = LightTables::get();
  glm::u64vec3 weighted(0), plain(0);
  uint64_t alpha = 0, weights = 0;
  for (uint32_t y = 0; y < down.count; ++y)
    for (uint32_t x = 0; x < across.count; ++x) {
      const glm::u8vec4 texel = image.at(across.first + x, down.first + y);
      const uint64_t weight = uint64_t{across.weights[x]} * down.weights[y];
      const glm::u64vec3 colour(light.linear(texel.r), light.linear(texel.g), light.linear(texel.b));
      weighted += weight * texel.a * colour;
      plain += weight * colour;
      alpha += weight * texel.a;
      weights += weight;
    }
  const glm::u64vec3 mean = alpha > 0 ? (weighted + alpha / 2) / alpha : (plain + weights / 2) / weights;
  return {light.srgb(mean.r), light.srgb(mean.g), light.srgb(mean.b),
          static_cast<uint8_t>((alpha + weights / 2) / weights)};
}

uint32_t wrapped(int64_t at, uint32_t size) {
  const int64_t rest = at % int64_t{size};
  return static_cast<uint32_t>(rest < 0 ? rest + size : rest);
}

}  // namespace

Image halved(const Image& image) {
  Image result;
  result.size = (image.size + 1u) / 2u;
  result.texels.reserve(size_t{result.size.x} * result.size.y);
  const std::vector<Cover> across = coversOf(image.size.x, result.size.x);
  const std::vector<Cover> down = coversOf(image.size.y, result.size.y);
  for (const Cover& row : down)
    for (const Cover& column : across) result.texels.push_back(meanOf(image, column, row));
  return result;
}

Image cutOut(const Image& image, glm::ivec2 first, glm::uvec2 size) {
  Image part;
  part.size = size;
  part.texels.reserve(size_t{size.x} * size.y);
  for (uint32_t y = 0; y < size.y; ++y) {
    const uint32_t row = wrapped(int64_t{first.y} + y, image.size.y);
    for (uint32_t x = 0; x < size.x; ++x)
      part.texels.push_back(image.at(wrapped(int64_t{first.x} + x, image.size.x), row));
  }
  return part;
}

}  // namespace lode
