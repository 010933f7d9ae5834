#include "server/store/cut.h"

#include <algorithm>
#include <set>

#include "tests/unit/store/store_files.h"

namespace lode::store {
namespace {

class CutTest : public testing::Test {
 protected:
  test::SyntheticModel model_ = test::closedModel();
  NodeTree tree_{model_.nodes};

  const Lod& lod(CutItem item) const { return tree_.node(item.node).lods[item.lod]; }
  uint64_t triangles(const Cut& cut) const {
    uint64_t sum = 0;
    for (const CutItem item : cut.items) sum += lod(item).triangles;
    return sum;
  }
};

TEST_F(CutTest, coversTheModelExactlyOnce) {
  for (double error = 0.1; error < 4000; error *= 1.3)
    EXPECT_TRUE(coversExactlyOnce(tree_, cutByError(tree_, error).items)) << error;
  for (uint64_t budget = 0; budget < 900; budget += 7)
    EXPECT_TRUE(coversExactlyOnce(tree_, cutByTriangles(tree_, budget).items)) << budget;
  for (uint64_t seed = 0; seed < 200; ++seed)
    EXPECT_TRUE(coversExactlyOnce(tree_, randomCut(tree_, seed).items)) << seed;
  EXPECT_TRUE(coversExactlyOnce(tree_, leafCut(tree_).items));
}

TEST_F(CutTest, isInvalidWithAMissingOrDuplicatePart) {
  const std::vector<CutItem> leaves = leafCut(tree_).items;
  std::vector<CutItem> items = leaves;
  items.pop_back();
  EXPECT_FALSE(coversExactlyOnce(tree_, items));
  items = leaves;
  items.push_back(items.back());
  EXPECT_FALSE(coversExactlyOnce(tree_, items));
  items = leaves;
  items.push_back({0, 0});
  EXPECT_FALSE(coversExactlyOnce(tree_, items));
  items = leaves;
  items.back().lod = 1;
  EXPECT_FALSE(coversExactlyOnce(tree_, items));
  EXPECT_FALSE(coversExactlyOnce(tree_, std::vector<CutItem>{{1000000, 0}}));
}

TEST_F(CutTest, sumsUpItsTriangles) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const Cut cut = randomCut(tree_, seed);
    EXPECT_EQ(cut.triangles, triangles(cut));
  }
  EXPECT_EQ(leafCut(tree_).triangles, 2u * 24 * 15);
}

TEST_F(CutTest, usesTheCoarsestLodWithinAnError) {
  for (double error = 0.3; error < 2000; error *= 1.7) {
    const Cut cut = cutByError(tree_, error);
    EXPECT_TRUE(cut.converged);
    EXPECT_LE(cut.max_error_model, error);
    for (const CutItem item : cut.items) {
      const Node& node = tree_.node(item.node);
      if (item.lod + 1 < node.lods.size()) {
        EXPECT_GT(node.lods[item.lod + 1].error_model, error);
      } else if (item.node != 0) {
        const auto parent = std::find_if(model_.nodes.begin(), model_.nodes.end(),
                                         [&](const Node& n) { return n.key == node.key.parent(); });
        EXPECT_GT(parent->lods[0].error_model, error);
      }
    }
  }
}

TEST_F(CutTest, hasFewerTrianglesForALargerError) {
  uint64_t last = ~uint64_t{0};
  for (double error = 0.1; error < 4000; error *= 1.1) {
    const Cut cut = cutByError(tree_, error);
    EXPECT_LE(cut.triangles, last);
    last = cut.triangles;
  }
  EXPECT_EQ(last, tree_.node(0).lods.back().triangles);
}

TEST_F(CutTest, reportsIfEvenTheLeavesExceedTheError) {
  const Cut cut = cutByError(tree_, 0);
  EXPECT_FALSE(cut.converged);
  EXPECT_EQ(cut.items, leafCut(tree_).items);
}

TEST_F(CutTest, keepsAndUsesATriangleBudget) {
  const uint64_t coarsest = tree_.node(0).lods.back().triangles;
  for (uint64_t budget = coarsest; budget < 900; budget += 3) {
    const Cut cut = cutByTriangles(tree_, budget);
    EXPECT_TRUE(cut.converged);
    EXPECT_LE(cut.triangles, budget);
    EXPECT_EQ(cut.triangles, triangles(cut));
  }
  EXPECT_EQ(cutByTriangles(tree_, 720).items, leafCut(tree_).items);
}

TEST_F(CutTest, refinesWithinATriangleBudgetUntilNoStepFits) {
  const auto sum = [&](uint32_t first, uint32_t count) {
    uint64_t triangles = 0;
    for (uint32_t i = first; i < first + count; ++i) triangles += tree_.node(i).lods.back().triangles;
    return triangles;
  };
  for (uint64_t budget = 300; budget < 720; budget += 11) {
    const Cut cut = cutByTriangles(tree_, budget);
    for (const CutItem item : cut.items) {
      const Node& node = tree_.node(item.node);
      if (item.lod == 0 && node.isLeaf()) continue;
      const uint64_t refined = item.lod > 0 ? node.lods[item.lod - 1].triangles
                                            : sum(tree_.firstChild(item.node), tree_.childCount(item.node));
      EXPECT_GT(cut.triangles - lod(item).triangles + refined, budget);
    }
  }
}

TEST_F(CutTest, reportsIfEvenTheCoarsestCutExceedsTheBudget) {
  const Cut cut = cutByTriangles(tree_, tree_.node(0).lods.back().triangles - 1);
  EXPECT_FALSE(cut.converged);
  EXPECT_EQ(cut.items, (std::vector<CutItem>{{0, 1}}));
}

// Two children: the one with the larger error does not fit, the other one does.
TEST(CutByTriangles, continuesWithSmallerStepsIfTheWorstDoesNotFit) {
  const auto node = [](uint64_t key, uint8_t mask, std::vector<uint32_t> triangles, float error) {
    Node made;
    made.key = {key};
    made.child_mask = mask;
    for (const uint32_t count : triangles) {
      made.lods.push_back({.payload = {}, .triangles = count, .error_model = error});
      error += 1;
    }
    return made;
  };
  const std::vector<Node> nodes{node(1, 0b11, {20}, 100), node(0b1000, 0b1, {10}, 50),
                                node(0b1001, 0b1, {10}, 40), node(0b1000000, 0, {1000}, 1),
                                node(0b1001000, 0, {15}, 1)};
  const NodeTree tree(nodes);
  const Cut cut = cutByTriangles(tree, 30);
  EXPECT_EQ(cut.items, (std::vector<CutItem>{{1, 0}, {4, 0}}));
}

/// Far LODs here have larger errors than the parent.
class CutWithFarLods : public testing::Test {
 protected:
  static test::SyntheticModel withFarLods() {
    return test::makeModel(test::makeSphere(24, 16, {.attributes = {}, .extent = 4000, .seed = 7}),
                           {.far_lods = 2});
  }
  test::SyntheticModel model_ = withFarLods();
  NodeTree tree_{model_.nodes};
};

TEST_F(CutWithFarLods, showsNoPartWorseThanItsParentWithinATriangleBudget) {
  for (uint64_t budget = tree_.node(0).lods.back().triangles; budget < 900; budget += 3) {
    const Cut cut = cutByTriangles(tree_, budget);
    EXPECT_TRUE(coversExactlyOnce(tree_, cut.items));
    EXPECT_LE(cut.triangles, budget);
    for (const CutItem item : cut.items) {
      const Node& node = tree_.node(item.node);
      if (node.key == kRootKey) continue;
      const auto parent = std::ranges::find(model_.nodes, node.key.parent(), &Node::key);
      EXPECT_LE(node.lods[item.lod].error_model, parent->lods[0].error_model);
    }
  }
  EXPECT_EQ(cutByTriangles(tree_, 720).items, leafCut(tree_).items);
}

TEST_F(CutWithFarLods, staysWithinAnErrorAndUsesFarLodsInRandomCuts) {
  bool takes_spare = false;
  for (double error = 0.3; error < 8000; error *= 1.2) {
    const Cut cut = cutByError(tree_, error);
    EXPECT_TRUE(coversExactlyOnce(tree_, cut.items));
    EXPECT_LE(cut.max_error_model, error);
  }
  for (uint64_t seed = 0; seed < 50; ++seed)
    for (const CutItem item : randomCut(tree_, seed).items) {
      const Node& node = tree_.node(item.node);
      takes_spare |= item.lod + node.far_lods >= node.lods.size();
    }
  EXPECT_TRUE(takes_spare);
}

TEST_F(CutTest, dependsOnlyOnTheSeedIfRandom) {
  std::set<uint64_t> sizes;
  bool mixed_lods = false;
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const Cut cut = randomCut(tree_, seed);
    EXPECT_EQ(cut.items, randomCut(tree_, seed).items);
    sizes.insert(cut.triangles);
    std::set<uint32_t> lods;
    for (const CutItem item : cut.items) lods.insert(item.lod);
    mixed_lods |= lods.size() > 1;
  }
  EXPECT_GT(sizes.size(), 10u);
  EXPECT_TRUE(mixed_lods);
}

}  // namespace
}  // namespace lode::store
