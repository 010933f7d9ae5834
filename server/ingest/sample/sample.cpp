#include "server/ingest/sample/sample.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <deque>
#include <functional>
#include <future>
#include <numbers>
#include <span>
#include <thread>
#include <vector>

#include <glm/glm.hpp>

#include "common/atomic_file.h"
#include "common/error.h"
#include "server/ingest/sample/asteroid_cube.h"
#include "server/ingest/sample/asteroid_relief.h"

namespace lode::ingest {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the records below are written as they lie in memory");

constexpr uint64_t kMaxTriangles = 4'000'000'000;  // vertex numbers stay below 2^31
constexpr uint64_t kBlockRows = 1u << 15;
constexpr uint8_t kAllowed = AttributeSet::kNormal | AttributeSet::kColour | AttributeSet::kTexture;

using Bytes = std::vector<std::byte>;

template <class T>
std::byte* put(std::byte* to, const T& value) {
  std::memcpy(to, &value, sizeof(value));
  return to + sizeof(value);
}

class Asteroid {
 public:
  Asteroid(uint64_t n, uint64_t seed, AttributeSet attributes)
      : n_(n),
        grid_(n),
        relief_(seed, 2.5 * std::numbers::pi / 2 / static_cast<double>(n)),
        attributes_(attributes) {
    // Equal angles rather than equal steps: the cells differ by a factor of 1.4 in area instead of 5.
    for (uint64_t i = 0; i <= n; ++i) {
      const double along = static_cast<double>(i) / static_cast<double>(n) - 0.5;
      coordinates_.push_back(std::tan(along * std::numbers::pi / 2));
    }
  }

  uint64_t vertices() const noexcept { return grid_.vertices(); }
  uint64_t squares() const noexcept { return grid_.squares(); }

  size_t vertexBytes() const noexcept {
    return 12 + (attributes_.has(AttributeSet::kNormal) ? 12 : 0) +
           (attributes_.has(AttributeSet::kColour) ? 3 : 0) +
           (attributes_.has(AttributeSet::kTexture) ? 8 : 0);
  }

  Bytes vertexRows(uint64_t first, uint64_t end) const {
    Bytes bytes((end - first) * vertexBytes());
    std::byte* to = bytes.data();
    for (uint64_t i = first; i < end; ++i) to = putVertex(to, i);
    return bytes;
  }

  Bytes faceRows(uint64_t first, uint64_t end) const {
    Bytes bytes((end - first) * 26);
    std::byte* to = bytes.data();
    for (uint64_t i = first; i < end; ++i) {
      const std::array<uint32_t, 4> c = grid_.square(i);
      const size_t turn = (i + i / n_) % 2;  // diagonals in both directions, so that the mesh favours none
      for (const size_t half : {size_t{0}, size_t{2}}) {
        to = put(to, uint8_t{3});
        for (size_t k = 0; k < 3; ++k) to = put(to, c[(turn + half + k) % 4]);
      }
    }
    return bytes;
  }

 private:
  std::byte* putVertex(std::byte* to, uint64_t number) const {
    const std::array<uint32_t, 3> at = grid_.vertex(number);
    const glm::dvec3 direction =
        glm::normalize(glm::dvec3(coordinates_[at[0]], coordinates_[at[1]], coordinates_[at[2]]));
    const bool with_normal = attributes_.has(AttributeSet::kNormal);
    const ReliefPoint relief = with_normal ? relief_.atWithGradient(direction) : relief_.at(direction);
    const double radius = 1 + relief.height;
    to = put(to, glm::vec3(direction * radius));
    if (with_normal) {
      const glm::dvec3 along = relief.gradient - glm::dot(relief.gradient, direction) * direction;
      to = put(to, glm::vec3(glm::normalize(direction * radius - along)));
    }
    if (attributes_.has(AttributeSet::kColour)) to = put(to, colour(relief));
    if (attributes_.has(AttributeSet::kTexture)) {
      to = put(to, glm::vec2(0.5 + 0.5 * direction.x, 0.5 + 0.5 * direction.y));
    }
    return to;
  }

  /// Dust in the hollows, rock on the heights, speckled by the finer octaves.
  static glm::u8vec3 colour(const ReliefPoint& relief) {
    const double rock = std::clamp(0.5 + 2.5 * relief.height, 0.0, 1.0);
    const double light = 1 + 0.6 * relief.fine_height;
    const glm::dvec3 mixed = glm::mix(glm::dvec3(92, 70, 58), glm::dvec3(196, 186, 170), rock) * light;
    return glm::u8vec3(glm::clamp(mixed + 0.5, 0.0, 255.0));
  }

  uint64_t n_;
  CubeGrid grid_;
  Relief relief_;
  AttributeSet attributes_;
  std::vector<double> coordinates_;
};

std::string headerOf(const SampleOptions& options, const Asteroid& asteroid) {
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment " + options.kind + ", seed " +
                       std::to_string(options.seed) + "\nelement vertex " +
                       std::to_string(asteroid.vertices()) +
                       "\nproperty float x\nproperty float y\nproperty float z\n";
  if (options.attributes.has(AttributeSet::kNormal)) {
    header += "property float nx\nproperty float ny\nproperty float nz\n";
  }
  if (options.attributes.has(AttributeSet::kColour)) {
    header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  }
  if (options.attributes.has(AttributeSet::kTexture)) header += "property float s\nproperty float t\n";
  return header + "element face " + std::to_string(2 * asteroid.squares()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

/// Computes blocks of rows on several threads and writes them in order; at most `threads` blocks are in
/// memory.
void writeRows(AtomicFile& file, uint64_t rows, unsigned threads,
               const std::function<Bytes(uint64_t, uint64_t)>& compute) {
  std::deque<std::future<Bytes>> blocks;
  for (uint64_t first = 0; first < rows || !blocks.empty();) {
    while (first < rows && blocks.size() < threads) {
      const uint64_t end = std::min(rows, first + kBlockRows);
      blocks.push_back(std::async(std::launch::async, compute, first, end));
      first = end;
    }
    const Bytes bytes = blocks.front().get();
    blocks.pop_front();
    file.write(bytes);
  }
}

}  // namespace

uint64_t writeSample(const SampleOptions& options, const std::filesystem::path& path) {
  if (options.kind != "asteroid") {
    throw Error(ErrorCode::kUsage, "unknown kind of sample '" + options.kind + "'; there is: asteroid");
  }
  if (options.triangles < 12 || options.triangles > kMaxTriangles) {
    throw Error(ErrorCode::kUsage, "a sample cannot have " + std::to_string(options.triangles) +
                                       " triangles; ask for 12 to " + std::to_string(kMaxTriangles));
  }
  if ((options.attributes.bits & ~kAllowed) != 0) {
    throw Error(ErrorCode::kUsage, "a sample has no such attribute; there are: normal, color, uv");
  }
  uint64_t n = 1;
  while (12 * (n + 1) * (n + 1) <= options.triangles) ++n;
  const unsigned threads =
      options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());

  const Asteroid asteroid(n, options.seed, options.attributes);
  const std::string header = headerOf(options, asteroid);
  AtomicFile file(path);
  file.write(std::as_bytes(std::span(header)));
  writeRows(file, asteroid.vertices(), threads,
            [&](uint64_t first, uint64_t end) { return asteroid.vertexRows(first, end); });
  writeRows(file, asteroid.squares(), threads,
            [&](uint64_t first, uint64_t end) { return asteroid.faceRows(first, end); });
  file.commit();
  return 2 * asteroid.squares();
}

}  // namespace lode::ingest
