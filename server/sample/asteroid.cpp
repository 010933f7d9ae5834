#include "server/sample/asteroid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "server/sample/cube_grid.h"
#include "server/sample/relief.h"

namespace lode::ingest {
namespace {

class Asteroid final : public SampleModel {
 public:
  Asteroid(uint64_t n, uint64_t seed, AttributeSet attributes)
      : SampleModel(attributes),
        n_(n),
        grid_(n),
        relief_(seed, 2.5 * std::numbers::pi / 2 / static_cast<double>(n)) {
    // Equal angles rather than equal steps: the cells differ by a factor of 1.4 in area instead of 5.
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
      const size_t turn = (i + i / n_) % 2;  // diagonals in both directions, so that the mesh favours none
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
  std::vector<double> coordinates_;
};

}  // namespace

std::unique_ptr<SampleModel> makeAsteroid(uint64_t triangles, uint64_t seed, AttributeSet attributes) {
  uint64_t n = 1;
  while (12 * (n + 1) * (n + 1) <= triangles) ++n;
  return std::make_unique<Asteroid>(n, seed, attributes);
}

}  // namespace lode::ingest
