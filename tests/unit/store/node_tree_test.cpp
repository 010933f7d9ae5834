#include "server/store/node_tree.h"

#include <cmath>
#include <functional>
#include <limits>

#include "common/limits.h"
#include "tests/unit/store/store_files.h"

namespace lode::store {
namespace {

/// Returns a valid hierarchy: a root with two children; the second child has one child.
std::vector<Node> soundNodes() {
  const auto node = [](uint64_t key, uint8_t mask, float error, size_t lods, uint32_t triangles) {
    Node made;
    made.key = {key};
    made.child_mask = mask;
    made.box = {glm::uvec3(0), glm::uvec3(100)};
    for (size_t i = 0; i < lods; ++i)
      made.lods.push_back({.payload = {1, 10, {}},
                           .triangles = triangles >> i,
                           .vertices = triangles,
                           .error_model = error + static_cast<float>(i)});
    return made;
  };
  return {node(1, 0b10010, 10, 3, 100), node(0b1001, 0, 1, 1, 40), node(0b1100, 0b1, 5, 2, 90),
          node(0b1100000, 0, 1, 1, 95)};
}

std::string check(const std::function<void(std::vector<Node>&)>& change) {
  std::vector<Node> nodes = soundNodes();
  change(nodes);
  return test::messageOf([&] { checkHierarchy(nodes); });
}

TEST(Hierarchy, isSoundAsTheTestsMakeIt) {
  const HierarchyTotals totals = checkHierarchy(soundNodes());
  EXPECT_EQ(totals.triangles, 40u + 95);
  EXPECT_EQ(totals.stored_triangles, 100u + 50 + 25 + 40 + 90 + 45 + 95);
  EXPECT_EQ(totals.payloads, 7u);
  EXPECT_EQ(totals.depth, 2u);
}

TEST(Hierarchy, rejectsAMissingRoot) {
  EXPECT_NE(check([](auto& nodes) { nodes.erase(nodes.begin()); }), "");
  EXPECT_NE(check([](auto& nodes) { nodes.clear(); }), "");
}

TEST(Hierarchy, rejectsAMissingChildOfTheMask) {
  EXPECT_NE(check([](auto& nodes) { nodes.erase(nodes.begin() + 1); }).find("missing"), std::string::npos);
  EXPECT_NE(check([](auto& nodes) { nodes[0].child_mask |= 1; }).find("missing"), std::string::npos);
}

TEST(Hierarchy, rejectsOrphansAndStrangers) {
  EXPECT_NE(check([](auto& nodes) { nodes.erase(nodes.begin() + 2); }), "");
  EXPECT_NE(check([](auto& nodes) { nodes[0].child_mask = 0b10000; }).find("child mask does not include it"),
            std::string::npos);
  EXPECT_NE(check([](auto& nodes) { nodes[3].key = {0b1111000}; }).find("parent is missing"),
            std::string::npos);
}

TEST(Hierarchy, rejectsNodesOutOfOrderOrTwice) {
  EXPECT_NE(check([](auto& nodes) { std::swap(nodes[1], nodes[2]); }), "");
  EXPECT_NE(check([](auto& nodes) { nodes.insert(nodes.begin() + 1, nodes[1]); }), "");
}

TEST(Hierarchy, rejectsInvalidKeys) {
  EXPECT_NE(check([](auto& nodes) { nodes[3].key = {0b100000}; }), "");
  EXPECT_NE(check([](auto& nodes) { nodes[3].key = {~uint64_t{0}}; }), "");
}

TEST(Hierarchy, rejectsErrorsThatFallTowardsCoarserLods) {
  EXPECT_NE(check([](auto& nodes) { nodes[0].lods[2].error_model = 10.5f; }).find("I3"), std::string::npos);
  EXPECT_NE(check([](auto& nodes) { nodes[2].lods[0].appearance_error_model = 1; }).find("I3"),
            std::string::npos);
}

TEST(Hierarchy, rejectsErrorsThatFallTowardsTheParent) {
  EXPECT_NE(check([](auto& nodes) { nodes[1].lods[0].error_model = 10.5f; }).find("I3"), std::string::npos);
  EXPECT_NE(check([](auto& nodes) { nodes[3].lods[0].appearance_error_model = 1; }).find("I3"),
            std::string::npos);
}

TEST(Hierarchy, takesFarLodsWithErrorsAboveTheParents) {
  const auto addSpare = [](std::vector<Node>& nodes) {
    nodes[2].lods.push_back(nodes[2].lods.back());
    nodes[2].lods.back().error_model = 20;
  };
  EXPECT_NE(check(addSpare).find("I3"), std::string::npos);
  EXPECT_EQ(check([&](auto& nodes) {
              addSpare(nodes);
              nodes[2].far_lods = 1;
            }),
            "");
}

TEST(Hierarchy, rejectsFarLodsOfTheRootAndMoreFarLodsThanLods) {
  EXPECT_NE(check([](auto& nodes) { nodes[0].far_lods = 1; }).find("far LODs"), std::string::npos);
  EXPECT_NE(check([](auto& nodes) { nodes[2].far_lods = 2; }).find("far LODs"), std::string::npos);
  EXPECT_NE(check([](auto& nodes) { nodes[3].far_lods = 1; }).find("far LODs"), std::string::npos);
}

TEST(Hierarchy, rejectsInvalidErrors) {
  for (const float error : {-1.0f, std::nanf(""), std::numeric_limits<float>::infinity()})
    EXPECT_NE(check([&](auto& nodes) { nodes[3].lods[0].error_model = error; }), "");
}

TEST(Hierarchy, rejectsCoarserLodsWithMoreTriangles) {
  EXPECT_NE(check([](auto& nodes) { nodes[0].lods[1].triangles = 101; }), "");
}

TEST(Hierarchy, rejectsLodsAboveTheLimits) {
  EXPECT_NE(check([](auto& nodes) { nodes[3].lods[0].triangles = kMaxLodTriangles + 1; }).find("limit"),
            std::string::npos);
  EXPECT_NE(check([](auto& nodes) { nodes[3].lods[0].vertices = kMaxLodVertices + 1; }).find("limit"),
            std::string::npos);
  EXPECT_NE(check([](auto& nodes) { nodes[0].lods.resize(kMaxLods + 1, nodes[0].lods[2]); }).find("more"),
            std::string::npos);
}

TEST(Hierarchy, rejectsTrianglesWithoutPayloadAndPayloadsWithoutTriangles) {
  EXPECT_NE(check([](auto& nodes) { nodes[3].lods[0].payload = {}; }), "");
  EXPECT_NE(check([](auto& nodes) { nodes[3].lods[0].triangles = 0; }), "");
}

TEST(Hierarchy, rejectsLeavesWithSeveralLodsExceptTheRoot) {
  EXPECT_NE(check([](auto& nodes) { nodes[3].lods.push_back(nodes[3].lods[0]); }), "");
  EXPECT_EQ(check([](auto& nodes) {
              nodes.resize(1);
              nodes[0].child_mask = 0;
            }),
            "");
}

TEST(Hierarchy, rejectsImpossibleCountsOfLockedVertices) {
  EXPECT_NE(check([](auto& nodes) { nodes[3].lods[0].locked = nodes[3].lods[0].vertices + 1; }), "");
  EXPECT_NE(check([](auto& nodes) { nodes[0].lods[0].locked = 1; }).find("root"), std::string::npos);
}

TEST(Hierarchy, rejectsBoxesThatLeaveTheParentOrTheLattice) {
  EXPECT_NE(check([](auto& nodes) { nodes[3].box.max.y = 101; }).find("parent"), std::string::npos);
  EXPECT_NE(check([](auto& nodes) { nodes[0].box.max.y = kMaxLattice + 1; }).find("lattice"),
            std::string::npos);
  EXPECT_NE(check([](auto& nodes) { nodes[3].box = {}; }).find("empty"), std::string::npos);
}

TEST(NodeTree, findsTheChildrenOfEveryNode) {
  const test::SyntheticModel model = test::closedModel();
  const NodeTree tree(model.nodes);
  for (uint32_t i = 0; i < model.nodes.size(); ++i) {
    unsigned child = 0;
    for (unsigned octant = 0; octant < 8; ++octant)
      if ((model.nodes[i].child_mask >> octant & 1) != 0) {
        EXPECT_EQ(tree.node(tree.firstChild(i) + child++).key, model.nodes[i].key.child(octant));
      }
    EXPECT_EQ(tree.childCount(i), child);
  }
}

}  // namespace
}  // namespace lode::store
