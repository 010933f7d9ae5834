#include "client/core/lod/hierarchy.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/unit/core/synthetic_model.h"

namespace lode::core {
namespace {

using fixture::SyntheticModel;

class HierarchyTest : public testing::Test {
 protected:
  void SetUp() override {
    for (const auto& [key, node] : model_.nodes())
      if (node.child_page) owner_ = key;
    ASSERT_TRUE(owner_.valid());
  }
  Hierarchy withRoot() const {
    Hierarchy hierarchy(model_.nodes().size());
    hierarchy.addRootPage(model_.rootPage());
    return hierarchy;
  }

  std::vector<NodeKey> ownersOfPages() const {
    std::vector<NodeKey> owners;
    for (const auto& [key, node] : model_.nodes())
      if (node.child_page) owners.push_back(key);
    return owners;
  }

  SyntheticModel model_{{.seed = 2}};
  NodeKey owner_{0};
};

TEST_F(HierarchyTest, knowsEveryNodeOnceAllPagesHaveArrived) {
  const Hierarchy all = model_.hierarchy();
  EXPECT_EQ(all.size(), model_.nodes().size());
  for (const auto& [key, node] : model_.nodes()) {
    ASSERT_TRUE(all.find(key));
    EXPECT_EQ(*all.find(key), node);
    EXPECT_TRUE(all.find(key)->childrenKnown());
  }
}

TEST_F(HierarchyTest, saysWhereChildrenAreNotKnownYet) {
  Hierarchy hierarchy = withRoot();
  EXPECT_FALSE(hierarchy.find(owner_)->childrenKnown());
  hierarchy.addPage(owner_, model_.pageBelow(owner_));
  EXPECT_TRUE(hierarchy.find(owner_)->childrenKnown());
}

TEST_F(HierarchyTest, refusesAPageThatComesTwice) {
  Hierarchy hierarchy = withRoot();
  EXPECT_THROW(hierarchy.addRootPage(model_.rootPage()), Error);
  hierarchy.addPage(owner_, model_.pageBelow(owner_));
  EXPECT_THROW(hierarchy.addPage(owner_, model_.pageBelow(owner_)), Error);
}

TEST_F(HierarchyTest, refusesAPageBelowANodeThatIsNotKnownOrHasNone) {
  Hierarchy hierarchy = withRoot();
  EXPECT_THROW(hierarchy.addPage(owner_.child(0), model_.pageBelow(owner_)), Error);
  EXPECT_THROW(hierarchy.addPage(kRootKey, model_.pageBelow(kRootKey)), Error);
}

TEST_F(HierarchyTest, refusesOtherChildrenThanTheOwnerAnnounced) {
  Hierarchy hierarchy = withRoot();
  HierarchyPage page = model_.pageBelow(owner_);
  const NodeKey first = page.nodes.front().key;
  std::erase_if(page.nodes, [&](const Node& node) { return first.contains(node.key); });
  EXPECT_THROW(hierarchy.addPage(owner_, page), Error);
  EXPECT_EQ(hierarchy.size(), model_.rootPage().nodes.size());
}

TEST_F(HierarchyTest, refusesAChildOutsideItsOwnersBox) {
  Hierarchy hierarchy = withRoot();
  HierarchyPage page = model_.pageBelow(owner_);
  page.nodes.front().box.add(glm::uvec3(kMaxLattice));
  EXPECT_THROW(hierarchy.addPage(owner_, page), Error);
}

TEST_F(HierarchyTest, refusesAChildWithALargerErrorThanItsOwner) {
  Hierarchy hierarchy = withRoot();
  HierarchyPage page = model_.pageBelow(owner_);
  for (Lod& lod : page.nodes.front().lods)
    lod.error_model = hierarchy.find(owner_)->lods.front().error_model * 2;
  EXPECT_THROW(hierarchy.addPage(owner_, page), Error);
}

TEST_F(HierarchyTest, takesAChildWhoseFarLodHasALargerErrorThanItsOwner) {
  Hierarchy hierarchy = withRoot();
  HierarchyPage page = model_.pageBelow(owner_);
  Node& child = page.nodes.front();
  child.lods.push_back(child.lods.back());
  child.lods.back().error_model = hierarchy.find(owner_)->lods.front().error_model * 2;
  ++child.far_lods;
  hierarchy.addPage(owner_, page);
  EXPECT_NE(hierarchy.find(child.key), nullptr);
}

TEST_F(HierarchyTest, refusesMoreNodesThanTheModelAnnounced) {
  Hierarchy hierarchy(model_.rootPage().nodes.size());
  hierarchy.addRootPage(model_.rootPage());
  try {
    hierarchy.addPage(owner_, model_.pageBelow(owner_));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kLimit);
  }
}

TEST_F(HierarchyTest, forgetsPagesThatAreNotInUseTheLeastRecentlyUsedFirst) {
  Hierarchy hierarchy = model_.hierarchy();
  const std::vector<NodeKey> owners = ownersOfPages();
  ASSERT_GE(owners.size(), 3u);
  for (const NodeKey owner : owners) hierarchy.use({{owner}}, UINT64_MAX);
  hierarchy.use({{owners.back()}}, hierarchy.bytes() - 1);
  EXPECT_FALSE(hierarchy.find(owners[0])->childrenKnown());
  EXPECT_TRUE(hierarchy.find(owners[1])->childrenKnown());
  hierarchy.use({{owners.back()}}, 0);
  EXPECT_TRUE(hierarchy.find(owners.back())->childrenKnown());
  hierarchy.use({}, 0);
  EXPECT_EQ(hierarchy.size(), model_.rootPage().nodes.size());
  EXPECT_EQ(hierarchy.bytes(), withRoot().bytes());
}

TEST_F(HierarchyTest, forgetsLostBlobsAboveTheLimit) {
  const uint32_t first = model_.nodes().at(kRootKey).lods.back().payload.number;
  constexpr uint32_t kOthers = 1u << 30;  // numbers of blobs that no node refers to
  for (const bool is_above : {false, true}) {
    Hierarchy hierarchy(model_.nodes().size());
    hierarchy.lose(first);
    for (uint32_t other = 1; other < kMaxLostBlobs + is_above; ++other) hierarchy.lose(kOthers + other);
    hierarchy.addRootPage(model_.rootPage());
    const KnownNode& root = *hierarchy.root();
    EXPECT_EQ(root.isLost(static_cast<uint32_t>(root.lods.size()) - 1), !is_above);
  }
}

TEST_F(HierarchyTest, acceptsAForgottenPageAgain) {
  Hierarchy hierarchy = model_.hierarchy();
  hierarchy.use({}, 0);
  hierarchy.addPage(owner_, model_.pageBelow(owner_));
  EXPECT_TRUE(hierarchy.find(owner_)->childrenKnown());
}

TEST(HierarchyMemory, keepsAPageWhileOneBelowItIsKnown) {
  const SyntheticModel model({.seed = 2, .depth = 6});
  Hierarchy hierarchy = model.hierarchy();
  NodeKey deep{0};
  for (const auto& [key, node] : model.nodes())
    if (node.child_page && key.depth() == 4) deep = key;
  ASSERT_TRUE(deep.valid());
  hierarchy.use({{deep}}, 0);
  ASSERT_TRUE(hierarchy.find(deep));
  EXPECT_TRUE(hierarchy.find(deep)->childrenKnown());
}

TEST(HierarchyMemory, forgetsAnUnusedPageWithThePagesBelowIt) {
  const SyntheticModel model({.seed = 2, .depth = 6});
  Hierarchy hierarchy = model.hierarchy();
  ASSERT_GT(hierarchy.size(), model.rootPage().nodes.size());
  hierarchy.use({}, 0);
  EXPECT_EQ(hierarchy.size(), model.rootPage().nodes.size());
}

TEST(HierarchyMemory, countsTheMemoryOfManyLods) {
  HierarchyPage page;
  Node root;
  root.key = kRootKey;
  root.lods.assign(64, Lod{});
  page.nodes = {root};
  Hierarchy many(1);
  many.addRootPage(page);
  page.nodes[0].lods.resize(1);
  Hierarchy one(1);
  one.addRootPage(page);
  EXPECT_EQ(many.bytes(), one.bytes() + 63 * sizeof(Lod));
}

}  // namespace
}  // namespace lode::core
