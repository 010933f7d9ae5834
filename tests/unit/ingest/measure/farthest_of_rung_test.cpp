#include "server/ingest/measure/farthest_of_rung.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "server/ingest/measure/surface_samples.h"
#include "server/ingest/measure/triangle_tree.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

float farthest(const SimplifiedMesh& rung, const NodeMesh& input, float known) {
  return farthestOfRung(rung, RungInput(input, 0), placesOn(rung, input, SurfaceWalk(rung.mesh)),
                        sourcesOf(rung, input), known);
}

TEST(FarthestOfRung, isWithinFivePercentOfWhatDensePointsFind) {
  const NodeMesh input = test::nodeOf(test::makeSphere(60, 40));
  collapse(input, std::array<size_t, 2>{1200, 100}, {}, [&](size_t, SimplifiedMesh&& rung) {
    const TriangleTree tree(input);
    double found = 0;
    for (const glm::dvec3 point : test::pointsOver(rung.mesh, 24))
      found = std::max<double>(found, tree.distance(glm::vec3(point)));
    const float measured = farthest(rung, input, 0);
    EXPECT_GE(1.05 * measured, found);
    EXPECT_LE(measured, 1.001 * found);
  });
}

TEST(FarthestOfRung, isNotBelowWhatIsKnown) {
  const NodeMesh mesh = test::nodeOf(test::makeGrid(4, 4));
  SimplifiedMesh same{mesh, std::vector<uint32_t>(mesh.positions.size())};
  std::iota(same.became.begin(), same.became.end(), 0u);
  EXPECT_EQ(farthest(same, mesh, 7), 7);
}

}  // namespace
}  // namespace lode::ingest
