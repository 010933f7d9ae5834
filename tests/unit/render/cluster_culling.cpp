#include "client/render/culling/cluster_culling.h"

#include <gtest/gtest.h>

#include "client/core/lod/triangle_clusters.h"
#include "gl_fixture.h"
#include "tests/support/test_meshes.h"
#include "tests/unit/render/silhouette.h"

namespace lode::test {
namespace {

using render::SeenCluster;

render::DrawItem itemOf(const Mesh& mesh) {
  render::DrawItem item;
  item.index_count = static_cast<uint32_t>(3 * mesh.triangles.size());
  for (const PositionCode position : mesh.positions) item.box.add(unpackPosition(position));
  item.clusters = std::make_shared<render::MeshClusters>(render::MeshClusters{mesh.cluster_boxes, {}});
  return item;
}

Mesh clusteredPlain() {
  Mesh mesh = makeGrid(97, 96, {.attributes = {}, .bump = 0.02});
  core::clusterTriangles(mesh);
  return mesh;
}

std::vector<SeenCluster> seenOf(const render::DrawItem& item, const core::View& view) {
  std::vector<SeenCluster> seen;
  const size_t added = addSeenClusters({&item, 7, true}, core::ViewFrustum(view, 1), 1, seen);
  EXPECT_EQ(added, seen.size());
  return seen;
}

TEST(ClusterCulling, leavesOutClustersOutsideThePicture) {
  const Mesh mesh = clusteredPlain();
  const render::DrawItem item = itemOf(mesh);
  const core::View view = lookAt({1000, 1000, 700}, {1000, 1000, 0});
  const core::ViewFrustum frustum(view, 1);
  std::vector<bool> is_seen(mesh.cluster_boxes.size());
  for (const SeenCluster& cluster : seenOf(item, view)) {
    EXPECT_NE(frustum.test(core::toModelBox(cluster.box(), 1)), core::Visibility::kOutside);
    EXPECT_EQ(cluster.part.state, 7u);
    EXPECT_TRUE(cluster.part.fades);
    is_seen[cluster.number] = true;
  }
  const auto count = static_cast<size_t>(std::ranges::count(is_seen, true));
  EXPECT_GT(count, 0u);
  EXPECT_LT(count, is_seen.size() / 2);
  for (size_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
    if (is_seen[triangle / kClusterTriangles]) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec2 place =
          projectTo(view, glm::dvec3(unpackPosition(mesh.positions[mesh.triangles[triangle][corner]])));
      EXPECT_FALSE(place.x >= 0 && place.y >= 0 && place.x <= view.width_px && place.y <= view.height_px);
    }
  }
}

TEST(ClusterCulling, takesAllOfAPartThatIsWhollyInThePicture) {
  const Mesh mesh = clusteredPlain();
  const render::DrawItem item = itemOf(mesh);
  const std::vector<SeenCluster> seen = seenOf(item, lookAt({2048, 2048, 9000}, {2048, 2048, 0}));
  ASSERT_EQ(seen.size(), mesh.cluster_boxes.size());
  uint64_t triangles = 0;
  for (const SeenCluster& cluster : seen) {
    EXPECT_EQ(cluster.firstTriangle(), triangles);
    triangles += cluster.triangles();
  }
  EXPECT_EQ(triangles, mesh.triangles.size());
}

TEST(ClusterCulling, keepsNoClusterBehindTheCamera) {
  const render::DrawItem item = itemOf(clusteredPlain());
  EXPECT_TRUE(seenOf(item, lookAt({2048, 2048, 9000}, {2048, 2048, 18000})).empty());
}

}  // namespace
}  // namespace lode::test
