#include "server/ingest/partition/normal_fans.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "common/codec/octahedral.h"
#include "common/codec/surface_normals.h"
#include "server/ingest/partition/leaf_mesh.h"
#include "server/ingest/plan/build_options.h"
#include "tests/support/machine_parts.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

uint32_t fansAt(const NormalFans& fans, uint32_t position) {
  return fans.first[position + 1] - fans.first[position];
}

TEST(NormalFans, areOneForEachSideThatMeetsAtAPositionOfACube) {
  const NodeMesh mesh = test::nodeOf(test::makeCube(4), 64);
  const NormalFans fans = findFans(mesh, CreaseAngle(50));
  for (uint32_t p = 0; p < mesh.positions.size(); ++p) {
    const glm::uvec3 at = unpackPosition(mesh.positions[p]);
    uint32_t sides = 0;
    for (int axis = 0; axis < 3; ++axis) sides += at[axis] == 256 || at[axis] == 320;
    EXPECT_EQ(fansAt(fans, p), sides);
  }
}

TEST(NormalFans, haveTheNormalOfTheirSide) {
  const NodeMesh mesh = test::nodeOf(test::makeCube(4), 64);
  const NormalFans fans = findFans(mesh, CreaseAngle(50));
  for (size_t c = 0; c < fans.of_corner.size(); ++c) {
    const glm::u32vec3& t = mesh.triangles[c / 3];
    const glm::vec3 a(unpackPosition(mesh.positions[t.x])), b(unpackPosition(mesh.positions[t.y])),
        d(unpackPosition(mesh.positions[t.z]));
    EXPECT_EQ(normalOf(fans.sums[fans.of_corner[c]]), encodeOctahedral(glm::cross(b - a, d - a)));
  }
}

TEST(NormalFans, areOneEverywhereOnASmoothSurfaceAndWithoutCreases) {
  const NodeMesh sphere = test::nodeOf(test::makeSphere(60, 40, {}));
  EXPECT_EQ(findFans(sphere, CreaseAngle(50)).sums.size(), sphere.positions.size());
  const NodeMesh cube = test::nodeOf(test::makeCube(2), 64);
  EXPECT_EQ(findFans(cube, CreaseAngle(180)).sums.size(), cube.positions.size());
}

/// Makes two squares that meet along the y axis, one of them folded up.
NodeMesh makeFold(double angle_deg) {
  const double angle = glm::radians(angle_deg);
  test::MachinePart fold;
  for (const double y : {0.0, 1.0}) {
    fold.positions.emplace_back(-1, y, 0);
    fold.positions.emplace_back(0, y, 0);
    fold.positions.emplace_back(std::cos(angle), y, std::sin(angle));
  }
  fold.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  return test::nodeOf(fold, 10000);
}

TEST(NormalFans, splitAtAChamferButNotInANineSidedBoreByDefault) {
  const CreaseAngle crease(BuildOptions().crease_angle_deg);
  EXPECT_EQ(fansAt(findFans(makeFold(45), crease), 1), 2u);
  EXPECT_EQ(fansAt(findFans(makeFold(360.0 / 9), crease), 1), 1u);
}

/// Makes a roof over the x axis with four positions on the ridge and two rows beside it. The slopes end at
/// x = 2, where the ridge has come down.
NodeMesh makeFadingRidge() {
  NodeMesh mesh;
  for (uint32_t x = 0; x < 4; ++x)
    for (uint32_t y = 0; y < 3; ++y)
      mesh.positions.push_back(packPosition({100 * x, 100 * y, y == 1 && x < 2 ? 200 : 0}));
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) mesh.wedge_position.push_back(i);
  mesh.lca_depth.assign(mesh.positions.size(), kNeverLocked);
  for (uint32_t x = 0; x < 3; ++x)
    for (uint32_t y = 0; y < 2; ++y) {
      const uint32_t a = 3 * x + y;
      mesh.triangles.emplace_back(a, a + 3, a + 4);
      mesh.triangles.emplace_back(a, a + 4, a + 1);
    }
  return mesh;
}

TEST(NormalFans, stayWholeWhereACreaseEnds) {
  const NodeMesh mesh = makeFadingRidge();
  const NormalFans fans = findFans(mesh, CreaseAngle(80));
  EXPECT_EQ(fansAt(fans, 1), 2u) << "at the gable";
  EXPECT_EQ(fansAt(fans, 10), 1u) << "on flat ground";
}

TEST(NormalFans, takeInTrianglesWithoutADirection) {
  NodeMesh mesh;
  mesh.positions = {packPosition({0, 0, 0}), packPosition({50, 0, 0}), packPosition({100, 0, 0}),
                    packPosition({0, 90, 0})};
  mesh.wedge_position = {0, 1, 2, 3};
  mesh.lca_depth.assign(4, kNeverLocked);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const NormalFans fans = findFans(mesh, CreaseAngle(50));
  EXPECT_EQ(fansAt(fans, 0), 1u);
  EXPECT_EQ(normalOf(fans.sums[fans.first[0]]), encodeOctahedral({0, 0, 1}));
}

/// Distributes triangles to leaves and joins the fans that the leaves list.
std::vector<std::set<uint16_t>> joinedNormals(const NodeMesh& whole, uint32_t leaves,
                                              const CreaseAngle& crease) {
  std::vector<std::vector<ListedFan>> listed(whole.positions.size());
  std::vector<uint32_t> all(whole.positions.size());
  for (uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  for (uint32_t leaf = 0; leaf < leaves; ++leaf) {
    NodeMesh part = whole;
    part.triangles.clear();
    for (size_t t = 0; t < whole.triangles.size(); ++t)
      if (t * 7919 / 3 % leaves == leaf) part.triangles.push_back(whole.triangles[t]);
    const NormalFans fans = findFans(part, crease);
    std::vector<uint32_t> used;
    std::vector<bool> is_used(all.size());
    for (const glm::u32vec3& t : part.triangles)
      for (int k = 0; k < 3; ++k) is_used[t[k]] = true;
    for (const uint32_t i : all)
      if (is_used[i]) used.push_back(i);
    auto lists = listFans(part, fans, used);
    for (size_t i = 0; i < used.size(); ++i)
      for (ListedFan& fan : lists[i]) {
        fan.leaf = leaf;
        listed[used[i]].push_back(fan);
      }
  }
  std::vector<std::set<uint16_t>> normals;
  for (const std::vector<ListedFan>& of_position : listed) {
    const std::vector<uint16_t> codes = joinFans(of_position, crease);
    normals.emplace_back(codes.begin(), codes.end());
  }
  return normals;
}

TEST(NormalFans, areIndependentOfHowLeavesShareTheTriangles) {
  const CreaseAngle crease(50);
  for (const NodeMesh& mesh :
       {test::nodeOf(test::makeBoredBox(32, 4), 1000), test::nodeOf(test::makeCube(5), 1000),
        test::nodeOf(test::makeTetrahedron(), 1000), test::nodeOf(test::makeSphere(20, 10, {}))}) {
    const auto whole = joinedNormals(mesh, 1, crease);
    for (const uint32_t leaves : {2u, 3u, 5u})
      EXPECT_EQ(joinedNormals(mesh, leaves, crease), whole) << leaves;
  }
}

}  // namespace
}  // namespace lode::ingest
