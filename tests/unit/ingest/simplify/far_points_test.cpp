#include "server/ingest/simplify/far_points.h"

#include <algorithm>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "server/ingest/mesh/point_triangle.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

/// Collapses of a bumpy sheet into one position, with a list of all points that were merged.
class Collapsing {
 public:
  explicit Collapsing(uint32_t seed)
      : mesh_(test::nodeOf(test::makeGrid(16, 16, {.attributes = {}, .seed = seed})), 0),
        around_(mesh_),
        far_points_(mesh_),
        random_(seed) {}

  /// Merges a neighbour into the position, at a point near both.
  /// @return the distance of the farthest point, as measured and true.
  std::pair<float, float> joinNext() {
    const uint32_t gone = mesh_.at(CollapseMesh::next(mesh_.around(kPosition).front()));
    std::uniform_real_distribution<double> share(0.2, 0.8);
    const glm::dvec3 from = mesh_.point(kPosition), along = mesh_.point(gone) - from;
    const glm::dvec3 to = glm::round(from + share(random_) * along) + glm::dvec3(0, 0, 3);
    if (moved_.empty()) moved_.emplace_back(from);
    moved_.emplace_back(mesh_.point(gone));
    around_.gather(kPosition, gone);
    const float found = far_points_.measure(around_, to);
    mesh_.merge(kPosition, gone, to, 0.5);
    mesh_.positions[kPosition].merged_at = 1;
    far_points_.join(kPosition);
    return {found, farthest()};
  }

 private:
  static constexpr uint32_t kPosition = 8 * 17 + 8;

  float farthest() const {
    float most = 0;
    for (const glm::vec3& point : moved_) {
      float least = std::numeric_limits<float>::infinity();
      for (const uint32_t corner : mesh_.around(kPosition)) {
        const glm::vec3 a(mesh_.point(kPosition));
        const glm::vec3 ab = glm::vec3(mesh_.point(mesh_.at(CollapseMesh::next(corner)))) - a;
        const glm::vec3 ac = glm::vec3(mesh_.point(mesh_.at(CollapseMesh::previous(corner)))) - a;
        least = std::min(least, squaredDistanceToTriangle(point - a, {ab, ac}));
      }
      most = std::max(most, least);
    }
    return most;
  }

  CollapseMesh mesh_;
  EdgeSurroundings around_;
  FarPoints far_points_;
  std::mt19937 random_;
  std::vector<glm::vec3> moved_;
};

TEST(FarPoints, findTheFarthestOfFewMovedPoints) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Collapsing collapsing(seed);
    for (int joined = 1; joined <= 4; ++joined) {
      const auto [found, farthest] = collapsing.joinNext();
      EXPECT_FLOAT_EQ(found, farthest) << seed << ' ' << joined;
    }
  }
}

TEST(FarPoints, keepTheFarthestOfManyMovedPoints) {
  int as_far = 0, looks = 0;
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Collapsing collapsing(seed);
    for (int joined = 1; joined <= 20; ++joined, ++looks) {
      const auto [found, farthest] = collapsing.joinNext();
      EXPECT_LE(found, farthest * 1.001f) << seed << ' ' << joined;
      as_far += found >= farthest * 0.999f;
    }
  }
  EXPECT_GT(as_far, looks * 3 / 4);
}

TEST(FarPoints, haveOnlyThePositionItselfBeforeAnyMove) {
  const auto look = [](const CollapseMesh& mesh) {
    EdgeSurroundings around(mesh);
    around.gather(6, 7);
    return FarPoints(mesh).measure(around, mesh.point(7));
  };
  EXPECT_GT(look({test::nodeOf(test::makeGrid(4, 4)), 0}), 0);  // distance of position 6 itself
  EXPECT_EQ(look({test::nodeOf(test::makeGrid(4, 4, {.attributes = {}, .bump = 0})), 0}), 0);
}

}  // namespace
}  // namespace lode::ingest
