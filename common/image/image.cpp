#include "common/image/image.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lode {
namespace {

constexpr int kLinearSteps = 65536;
/// Linear light of each sRGB byte, in 16 bits (IEC 61966-2-1). The values are in a table, because stores must
/// have the same bytes on all machines, and the last bit of pow() differs between processors.
constexpr std::array<uint16_t, 256> kLinear{
    0,     20,    40,    60,    80,    99,    119,   139,   159,   179,   199,   219,   241,   264,   288,
    313,   340,   367,   396,   427,   458,   491,   526,   562,   599,   637,   677,   718,   761,   805,
    851,   898,   947,   997,   1048,  1101,  1156,  1212,  1270,  1330,  1391,  1453,  1517,  1583,  1651,
    1720,  1790,  1863,  1937,  2013,  2090,  2170,  2250,  2333,  2418,  2504,  2592,  2681,  2773,  2866,
    2961,  3058,  3157,  3258,  3360,  3464,  3570,  3678,  3788,  3900,  4014,  4129,  4247,  4366,  4488,
    4611,  4736,  4864,  4993,  5124,  5257,  5392,  5530,  5669,  5810,  5953,  6099,  6246,  6395,  6547,
    6700,  6856,  7014,  7174,  7335,  7500,  7666,  7834,  8004,  8177,  8352,  8528,  8708,  8889,  9072,
    9258,  9445,  9635,  9828,  10022, 10219, 10417, 10619, 10822, 11028, 11235, 11446, 11658, 11873, 12090,
    12309, 12530, 12754, 12980, 13209, 13440, 13673, 13909, 14146, 14387, 14629, 14874, 15122, 15371, 15623,
    15878, 16135, 16394, 16656, 16920, 17187, 17456, 17727, 18001, 18277, 18556, 18837, 19121, 19407, 19696,
    19987, 20281, 20577, 20876, 21177, 21481, 21787, 22096, 22407, 22721, 23038, 23357, 23678, 24002, 24329,
    24658, 24990, 25325, 25662, 26001, 26344, 26688, 27036, 27386, 27739, 28094, 28452, 28813, 29176, 29542,
    29911, 30282, 30656, 31033, 31412, 31794, 32179, 32567, 32957, 33350, 33745, 34143, 34544, 34948, 35355,
    35764, 36176, 36591, 37008, 37429, 37852, 38278, 38706, 39138, 39572, 40009, 40449, 40891, 41337, 41785,
    42236, 42690, 43147, 43606, 44069, 44534, 45002, 45473, 45947, 46423, 46903, 47385, 47871, 48359, 48850,
    49344, 49841, 50341, 50844, 51349, 51858, 52369, 52884, 53401, 53921, 54445, 54971, 55500, 56032, 56567,
    57105, 57646, 58190, 58737, 59287, 59840, 60396, 60955, 61517, 62082, 62650, 63221, 63795, 64372, 64952,
    65535,
};

/// Table of the nearest sRGB byte for each 16-bit value of linear light.
class SrgbTable {
 public:
  static const SrgbTable& get() {
    static const SrgbTable table;
    return table;
  }
  uint8_t srgb(uint64_t linear) const noexcept { return srgb_[linear]; }

 private:
  SrgbTable() : srgb_(kLinearSteps) {
    size_t value = 0;
    for (size_t i = 0; i < srgb_.size(); ++i) {
      while (value < 255 && 2 * i >= size_t{kLinear[value]} + kLinear[value + 1]) ++value;
      srgb_[i] = static_cast<uint8_t>(value);
    }
  }

  std::vector<uint8_t> srgb_;
};

/// The texels of a row or column that one coarser texel covers, each with its covered share as weight.
struct Cover {
  uint32_t first = 0, count = 0;
  std::array<uint32_t, 3> weights{};  ///< their sum is the number of texels in the finer row
};

std::vector<Cover> coversOf(uint32_t from, uint32_t to) {
  std::vector<Cover> covers(to);
  for (uint64_t i = 0; i < to; ++i) {
    // Positions in the finer row or column, in units of 1 / `to` of a texel.
    const uint64_t begin = i * from, end = begin + from;
    Cover& cover = covers[i];
    cover.first = static_cast<uint32_t>(begin / to);
    for (uint64_t j = cover.first; j * to < end; ++j)
      cover.weights[cover.count++] =
          static_cast<uint32_t>(std::min(end, (j + 1) * to) - std::max(begin, j * to));
  }
  return covers;
}

glm::u8vec4 meanOf(const Image& image, const Cover& across, const Cover& down) {
  const SrgbTable& table = SrgbTable::get();
  glm::u64vec3 weighted(0), plain(0);
  uint64_t alpha = 0, weights = 0;
  for (uint32_t y = 0; y < down.count; ++y)
    for (uint32_t x = 0; x < across.count; ++x) {
      const glm::u8vec4 texel = image.at(across.first + x, down.first + y);
      const uint64_t weight = uint64_t{across.weights[x]} * down.weights[y];
      const glm::u64vec3 colour(kLinear[texel.r], kLinear[texel.g], kLinear[texel.b]);
      weighted += weight * texel.a * colour;
      plain += weight * colour;
      alpha += weight * texel.a;
      weights += weight;
    }
  const glm::u64vec3 mean = alpha > 0 ? (weighted + alpha / 2) / alpha : (plain + weights / 2) / weights;
  return {table.srgb(mean.r), table.srgb(mean.g), table.srgb(mean.b),
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

double linearOf(uint8_t srgb) noexcept {
  const double encoded = srgb / 255.0;
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

uint8_t srgbOf(double linear) noexcept {
  const double part = std::clamp(linear, 0.0, 1.0);
  const double encoded = part <= 0.0031308 ? part * 12.92 : 1.055 * std::pow(part, 1 / 2.4) - 0.055;
  return static_cast<uint8_t>(std::lround(255 * encoded));
}

}  // namespace lode
