#include "server/sample/asteroid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "server/sample/relief.h"

namespace lode::ingest {
namespace {

/// Surface of a cube, divided into n x n squares per side. The sides share their border vertices, so the
/// surface has 6 n^2 + 2 vertices and 6 n^2 squares. Vertices and squares are computed from their indices,
/// without tables. Vertices are numbered by layers of z: first the bottom, then rings, then the top.
class CubeGrid {
 public:
  explicit CubeGrid(uint64_t n) : n_(n) {}

  uint64_t vertices() const noexcept { return 6 * n_ * n_ + 2; }
  uint64_t squares() const noexcept { return 6 * n_ * n_; }

  /// Returns the grid coordinates of a vertex, each in 0..n.
  std::array<uint32_t, 3> vertex(uint64_t number) const noexcept {
    const uint64_t layer = (n_ + 1) * (n_ + 1);
    const uint64_t rings = 4 * n_ * (n_ - 1);
    if (number >= layer && number < layer + rings) {
      const uint64_t in_rings = number - layer;
      return ringVertex(in_rings / (4 * n_) + 1, in_rings % (4 * n_));
    }
    const bool top = number >= layer;
    const uint64_t in_layer = top ? number - layer - rings : number;
    return {static_cast<uint32_t>(in_layer % (n_ + 1)), static_cast<uint32_t>(in_layer / (n_ + 1)),
            static_cast<uint32_t>(top ? n_ : 0)};
  }

  /// Returns the vertices of a square, counter-clockwise seen from outside.
  std::array<uint32_t, 4> square(uint64_t number) const noexcept {
    const uint64_t face = n_ * n_;
    if (number < face) {
      const auto [a, b, c, d] = flatSquare(number, 0);
      return {a, d, c, b};
    }
    if (number >= 5 * face) return flatSquare(number - 5 * face, (n_ + 1) * (n_ + 1) + 4 * n_ * (n_ - 1));
    const uint64_t z = (number - face) / (4 * n_);
    const uint64_t along = (number - face) % (4 * n_);
    const uint64_t next = along + 1 == 4 * n_ ? 0 : along + 1;
    return {ringNumber(z, along), ringNumber(z, next), ringNumber(z + 1, next), ringNumber(z + 1, along)};
  }

 private:
  /// Returns the grid coordinates of a vertex on a ring. Rings run around the four sides, counter-clockwise
  /// seen from above.
  std::array<uint32_t, 3> ringVertex(uint64_t z, uint64_t along) const noexcept {
    const uint64_t at = along % n_;
    const auto point = [&](uint64_t x, uint64_t y) {
      return std::array<uint32_t, 3>{static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                                     static_cast<uint32_t>(z)};
    };
    switch (along / n_) {
      case 0:
        return point(at, 0);
      case 1:
        return point(n_, at);
      case 2:
        return point(n_ - at, n_);
      default:
        return point(0, n_ - at);
    }
  }

  uint32_t ringNumber(uint64_t z, uint64_t along) const noexcept {
    const uint64_t layer = (n_ + 1) * (n_ + 1);
    if (z > 0 && z < n_) return static_cast<uint32_t>(layer + (z - 1) * 4 * n_ + along);
    const std::array<uint32_t, 3> at = ringVertex(z, along);
    return static_cast<uint32_t>((z == 0 ? 0 : layer + 4 * n_ * (n_ - 1)) + at[1] * (n_ + 1) + at[0]);
  }

  std::array<uint32_t, 4> flatSquare(uint64_t number, uint64_t first_vertex) const noexcept {
    const uint64_t a = first_vertex + number / n_ * (n_ + 1) + number % n_;
    return {static_cast<uint32_t>(a), static_cast<uint32_t>(a + 1), static_cast<uint32_t>(a + n_ + 2),
            static_cast<uint32_t>(a + n_ + 1)};
  }

  uint64_t n_;
};

class Asteroid final : public SampleModel {
 public:
  Asteroid(uint64_t n, uint64_t seed, AttributeSet attributes)
      : SampleModel(attributes),
        n_(n),
        grid_(n),
        relief_(seed, 2.5 * std::numbers::pi / 2 / static_cast<double>(n)) {
    // Use equal angles instead of equal steps, so that the areas of squares differ by a factor of 1.4 instead
    // of 5.
    for (uint64_t i = 0; i <= n; ++i) {
      const double along = static_cast<double>(i) / static_cast<double>(n) - 0.5;
      coordinates_.push_back(std::tan(along * std::numbers::pi / 2));
    }
  }

  uint64_t vertices() const override { return grid_.vertices(); }
  uint64_t triangles() const override { return 2 * grid_.squares(); }
  uint64_t blocks() const override { return RowRange::blocksOf(grid_.squares()); }

  void addVertices(uint64_t block, std::vector<SampleVertex>& to) const override {
    const RowRange rows = RowRange::ofBlock(block, blocks(), grid_.vertices());
    for (uint64_t i = rows.first; i < rows.end; ++i) to.push_back(vertex(i));
  }

  void addTriangles(uint64_t block, std::vector<glm::u32vec3>& to) const override {
    const RowRange rows = RowRange::ofBlock(block, blocks(), grid_.squares());
    for (uint64_t i = rows.first; i < rows.end; ++i) {
      const std::array<uint32_t, 4> c = grid_.square(i);
      // Alternate the diagonals, so that the mesh has no preferred direction.
      const size_t turn = (i + i / n_) % 2;
      for (const size_t half : {turn, turn + 2}) {
        to.emplace_back(c[half % 4], c[(half + 1) % 4], c[(half + 2) % 4]);
      }
    }
  }

 private:
  SampleVertex vertex(uint64_t number) const {
    const std::array<uint32_t, 3> at = grid_.vertex(number);
    const glm::dvec3 direction =
        glm::normalize(glm::dvec3(coordinates_[at[0]], coordinates_[at[1]], coordinates_[at[2]]));
    const bool with_normal = wants(AttributeSet::kNormal);
    const ReliefPoint relief = with_normal ? relief_.atWithGradient(direction) : relief_.at(direction);
    const double radius = 1 + relief.height;
    SampleVertex vertex;
    vertex.position = direction * radius;
    if (with_normal) {
      const glm::dvec3 along = relief.gradient - glm::dot(relief.gradient, direction) * direction;
      vertex.normal = glm::normalize(direction * radius - along);
    }
    if (wants(AttributeSet::kColour)) vertex.colour = colour(relief);
    vertex.uv = {0.5 + 0.5 * direction.x, 0.5 + 0.5 * direction.y};
    return vertex;
  }

  /// Returns the colour of dust in hollows or of rock on heights, speckled by the fine octaves.
  static glm::u8vec3 colour(const ReliefPoint& relief) {
    const double rock = std::clamp(0.5 + 2.5 * relief.height, 0.0, 1.0);
    const double light = 1 + 0.6 * relief.fine_height;
    const glm::dvec3 mixed = glm::mix(glm::dvec3(92, 70, 58), glm::dvec3(196, 186, 170), rock) * light;
    return glm::u8vec3(glm::clamp(mixed + 0.5, 0.0, 255.0));
  }

  uint64_t n_;
  CubeGrid grid_;
  Relief relief_;
  std::vector<double> coordinates_;
};

}  // namespace

std::unique_ptr<SampleModel> makeAsteroid(uint64_t triangles, uint64_t seed, AttributeSet attributes) {
  uint64_t n = 1;
  while (12 * (n + 1) * (n + 1) <= triangles) ++n;
  return std::make_unique<Asteroid>(n, seed, attributes);
}

}  // namespace lode::ingest
