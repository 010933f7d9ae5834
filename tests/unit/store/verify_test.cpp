#include "server/store/verify.h"

#include <functional>

#include "server/store/open_edges.h"
#include "server/store/segment_tree.h"
#include "tests/unit/store/store_files.h"

namespace lode::store {
namespace {

class VerifyTest : public testing::Test {
 protected:
  /// Writes a model and verifies it. @return the error message.
  std::string verify(test::SyntheticModel model) {
    test::writeStore(folder_ / "a.lode", model);
    return test::messageOf([&] { report_ = verifyStore(folder_ / "a.lode", {.random_cuts = 10}); });
  }

  test::WorkFolder folder_;
  VerifyReport report_;
};

TEST_F(VerifyTest, acceptsAClosedModel) {
  EXPECT_EQ(verify(test::closedModel()), "");
  EXPECT_EQ(report_.open_edges, 0u);
  EXPECT_EQ(report_.cuts, 10u);
  EXPECT_GT(report_.payloads, 20u);
}

TEST_F(VerifyTest, acceptsAModelWithABoundary) {
  EXPECT_EQ(verify(test::makeModel(test::makeGrid(12, 12, {.attributes = {}, .extent = 4000}))), "");
  EXPECT_EQ(report_.open_edges, 4u * 12);
}

TEST_F(VerifyTest, findsAHoleThatTheLeavesDoNotHave) {
  test::SyntheticModel model = test::closedModel();
  for (Node& node : model.nodes) {
    if (node.isLeaf() || node.lods[1].triangles == 0) continue;
    model.meshes.at({node.key, 1}).triangles.pop_back();
    node.lods[1].triangles -= 1;
  }
  EXPECT_NE(verify(std::move(model)).find("where the model is closed (I2)"), std::string::npos);
}

TEST_F(VerifyTest, findsABoundaryFarFromTheOriginalOne) {
  test::SyntheticModel model = test::makeModel(test::makeGrid(12, 12, {.attributes = {}, .extent = 4000}));
  for (Node& node : model.nodes)
    for (Lod& lod : node.lods) lod.error_model = 0.01f;
  EXPECT_NE(verify(std::move(model)).find("I2"), std::string::npos);
}

TEST_F(VerifyTest, findsAnotherNumberOfTriangles) {
  test::SyntheticModel model = test::closedModel();
  model.nodes.back().lods[0].triangles += 1;
  EXPECT_NE(verify(std::move(model)), "");
}

TEST_F(VerifyTest, findsAVertexOutsideItsNodesBox) {
  test::SyntheticModel model = test::closedModel();
  model.nodes.back().box.max = model.nodes.back().box.min;
  EXPECT_NE(verify(std::move(model)).find("box"), std::string::npos);
}

TEST_F(VerifyTest, findsATriangleWithTwoCornersAtOnePlace) {
  const AttributeSet attributes{AttributeSet::kColour};
  test::SyntheticModel model = test::closedModel(attributes);
  Mesh& mesh = model.meshes.at({model.nodes.back().key, 0});
  const glm::u32vec3 t = mesh.triangles[0];
  mesh.positions.push_back(mesh.positions[t.x]);
  mesh.vertex_attributes.push_back({});
  mesh.triangles[0].y = static_cast<uint32_t>(mesh.positions.size() - 1);
  EXPECT_NE(verify(std::move(model)), "");
}

TEST_F(VerifyTest, findsMoreLockedVerticesThanPositions) {
  test::SyntheticModel model = test::closedModel({AttributeSet::kTexture});
  bool changed = false;
  for (Node& node : model.nodes) {
    Lod& lod = node.lods[0];
    std::vector<PositionCode> distinct = model.meshes.at({node.key, 0}).positions;
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    if (node.key == kRootKey || distinct.size() >= lod.vertices) continue;
    lod.locked = static_cast<uint32_t>(distinct.size() + 1);
    changed = true;
    break;
  }
  ASSERT_TRUE(changed);
  EXPECT_NE(verify(std::move(model)).find("locked"), std::string::npos);
}

TEST(OpenEdges, areThoseUsedByAnOddNumberOfTriangles) {
  const Mesh closed = test::makeSphere(12, 8, {.attributes = {}, .extent = 1000});
  OpenEdges none;
  none.add(closed);
  EXPECT_TRUE(none.edges().empty());
  OpenEdges some;
  some.add(test::makeGrid(5, 7));
  EXPECT_EQ(some.edges().size(), 24u);
}

TEST(OpenEdges, cancelAcrossMeshes) {
  const Mesh closed = test::makeSphere(60, 40, {.attributes = {}, .extent = 100000});
  OpenEdges edges;
  for (size_t first = 0; first < closed.triangles.size(); first += 100) {
    Mesh part = closed;
    part.triangles.assign(
        closed.triangles.begin() + static_cast<ptrdiff_t>(first),
        closed.triangles.begin() + static_cast<ptrdiff_t>(std::min(first + 100, closed.triangles.size())));
    edges.add(part);
  }
  EXPECT_TRUE(edges.edges().empty());
}

TEST(OpenEdges, cancelWhileMoreAreAddedThanAreKept) {
  constexpr uint32_t kEdges = 100000;
  std::vector<OpenEdge> all;
  for (uint32_t i = 0; i < kEdges; ++i) all.push_back({PositionCode{i}, PositionCode{i + 1}});
  OpenEdges edges;
  edges.add(std::span(all).first(kEdges - 1));
  edges.add(all);
  EXPECT_EQ(edges.edges(), std::vector<OpenEdge>{all.back()});
}

TEST(SegmentTree, findsTheSameDistanceAsLookingAtAll) {
  std::mt19937 random(5);
  const auto point = [&] { return glm::dvec3(random() % 1000, random() % 1000, random() % 1000); };
  std::vector<Segment> segments(500);
  for (Segment& segment : segments) {
    segment.from = point();
    segment.to = segment.from + point() * 0.1;
  }
  const SegmentTree tree(segments);
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 p = point();
    double best = 1e30;
    for (const Segment& segment : segments) best = std::min(best, SegmentTree({segment}).distance(p));
    EXPECT_NEAR(tree.distance(p), best, 1e-9);
  }
}

TEST(SegmentTree, measuresToTheNearestPointOfASegment) {
  const SegmentTree tree({{{0, 0, 0}, {10, 0, 0}}});
  EXPECT_DOUBLE_EQ(tree.distance({5, 3, 4}), 5);
  EXPECT_DOUBLE_EQ(tree.distance({-3, 4, 0}), 5);
  EXPECT_DOUBLE_EQ(tree.distance({13, 0, 4}), 5);
  EXPECT_EQ(SegmentTree({}).distance({0, 0, 0}), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace lode::store
