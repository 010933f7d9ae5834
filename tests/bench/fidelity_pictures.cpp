#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "server/ingest/textures/image_decoder.h"
#include "tests/bench/fidelity_parts.h"
#include "tests/bench/print_row.h"

namespace lode::bench {
namespace {

constexpr uint64_t kMemory = 1u << 30;
constexpr int kDither = 8;  // largest difference from a row's background colour

Image readPicture(const char* path, int halvings) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  std::string damage;
  Image picture = ingest::decodeImage(std::as_bytes(std::span(bytes)), kMemory, damage);
  for (; halvings > 0; --halvings) picture = halved(picture);
  return picture;
}

int largestDifference(glm::u8vec4 a, glm::u8vec4 b) {
  int largest = 0;
  for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(int{a[k]} - int{b[k]}));
  return largest;
}

bool isDrawn(const Image& picture, uint32_t x, uint32_t y) {
  return largestDifference(picture.at(x, y), picture.at(picture.size.x - 1, y)) > kDither;
}

struct Comparison {
  double inside_db = 0;  ///< PSNR of the pixels where both show the model
  double all_db = 0;     ///< PSNR of the pixels where at least one shows the model
  double share = 0;      ///< share of the picture that the model covers
};

double decibels(double squares, double count) {
  if (squares == 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(255.0 * 255.0 * 3 * count / squares);
}

Comparison compare(const Image& full, const Image& other) {
  double inside = 0, all = 0, inside_count = 0, all_count = 0;
  for (uint32_t y = 0; y < full.size.y; ++y) {
    for (uint32_t x = 0; x < full.size.x; ++x) {
      const bool a = isDrawn(full, x, y), b = isDrawn(other, x, y);
      if (!a && !b) continue;
      const glm::dvec3 d = glm::dvec3(full.at(x, y)) - glm::dvec3(other.at(x, y));
      all += glm::dot(d, d);
      ++all_count;
      if (!a || !b) continue;
      inside += glm::dot(d, d);
      ++inside_count;
    }
  }
  const double pixels = static_cast<double>(full.size.x) * full.size.y;
  return {decibels(inside, inside_count), decibels(all, all_count), inside_count / pixels};
}

}  // namespace

void comparePictures(std::span<char* const> pairs, int halvings) {
  for (size_t i = 0; i + 1 < pairs.size(); i += 2) {
    const Image full = readPicture(pairs[i], halvings), other = readPicture(pairs[i + 1], halvings);
    if (full.size != other.size) {
      std::fprintf(stderr, "bench_fidelity: %s and %s differ in size\n", pairs[i], pairs[i + 1]);
      continue;
    }
    const Comparison result = compare(full, other);
    const auto decibels_of = [](double db) {  // equal pictures have no finite ratio
      return std::isfinite(db) ? nlohmann::ordered_json(db) : nlohmann::ordered_json();
    };
    printRow({{"picture", pairs[i + 1]},
              {"inside_db", decibels_of(result.inside_db)},
              {"with_boundary_db", decibels_of(result.all_db)},
              {"share", result.share}});
  }
}

}  // namespace lode::bench
