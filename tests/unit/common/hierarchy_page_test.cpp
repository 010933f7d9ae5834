#include "common/codec/hierarchy_page.h"

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/limits.h"
#include "tests/support/test_pages.h"

namespace lode {
namespace {

using test::makePage;
using test::PageOptions;

constexpr NodeKey kOwner = kRootKey.child(3).child(5);

void expectRoundTrip(const PageOptions& options) {
  const HierarchyPage page = makePage(options);
  EXPECT_EQ(decodePage(encodePage(page), options.owner, options.is_root_page), page);
}

TEST(HierarchyPage, decodesToTheEncodedPage) {
  for (const bool is_root_page : {false, true})
    for (unsigned children = is_root_page ? 0 : 1; children <= 8; ++children)
      for (const bool deeper_pages : {false, true}) {
        SCOPED_TRACE(children);
        expectRoundTrip({is_root_page ? kRootKey : kOwner, is_root_page, children + 1, children,
                         1 + children / 3, deeper_pages && children > 0});
      }
}

TEST(HierarchyPage, decodesWithTheDeepestLevels) {
  NodeKey owner = kRootKey;
  while (owner.depth() < kMaxDepth - 2) owner = owner.child(7);
  expectRoundTrip({owner, false, 1, 8, 1, true});
}

TEST(HierarchyPage, decodesWithFarLodErrorsAboveTheParents) {
  expectRoundTrip({.far_lods = 2});
  expectRoundTrip({.owner = kOwner, .is_root_page = false, .far_lods = 1, .deeper_pages = true});
}

TEST(HierarchyPage, decodesWithEmptyLods) {
  HierarchyPage page = makePage({.children = 2});
  for (Node& node : page.nodes) {
    node.box = {};
    for (Lod& lod : node.lods) lod = {{}, 0, 0, 0, lod.error_model, lod.appearance_error_model};
  }
  EXPECT_EQ(decodePage(encodePage(page), kRootKey, true), page);
}

TEST(HierarchyPage, takesAboutAHundredBytesANode) {
  const HierarchyPage page = makePage({.lods = 2, .deeper_pages = true});
  EXPECT_LT(encodePage(page).size(), 125 * page.nodes.size());
}

TEST(HierarchyPage, refusesOrRevealsEveryChangedByte) {
  const HierarchyPage page = makePage({.children = 3, .deeper_pages = true});
  std::vector<std::byte> bytes = encodePage(page);
  for (std::byte& byte : bytes) {
    const std::byte before = byte;
    for (unsigned value = 0; value < 256; ++value) {
      byte = static_cast<std::byte>(value);
      if (byte == before) continue;
      try {
        ASSERT_NE(decodePage(bytes, kRootKey, true), page) << &byte - bytes.data() << ' ' << value;
      } catch (const Error& error) {
        ASSERT_TRUE(error.code() == ErrorCode::kFormat || error.code() == ErrorCode::kLimit) << error.what();
      }
    }
    byte = before;
  }
}

TEST(HierarchyPage, everyTruncationIsRefused) {
  const std::vector<std::byte> bytes = encodePage(makePage({.children = 2}));
  for (size_t length = 0; length < bytes.size(); ++length)
    EXPECT_THROW(decodePage(std::span(bytes).first(length), kRootKey, true), Error) << length;
}

TEST(HierarchyPage, bytesAfterTheEndAreRefused) {
  std::vector<std::byte> bytes = encodePage(makePage({}));
  bytes.push_back(std::byte{0});
  EXPECT_THROW(decodePage(bytes, kRootKey, true), Error);
}

// Expects that a page is valid, and that decodePage() refuses it with this code after `spoil`.
void expectRefused(ErrorCode code, const std::function<void(std::vector<Node>&)>& spoil,
                   const PageOptions& options = {}) {
  HierarchyPage page = makePage(options);
  ASSERT_NO_THROW(decodePage(encodePage(page), options.owner, options.is_root_page));
  spoil(page.nodes);
  try {
    decodePage(encodePage(page), options.owner, options.is_root_page);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
  }
}

TEST(HierarchyPage, refusesKeysOutOfOrder) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { std::swap(nodes[3], nodes[4]); });
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[4] = nodes[3]; });
}

TEST(HierarchyPage, refusesInvalidKeys) {
  for (const uint64_t key : {uint64_t{0}, uint64_t{2}, ~uint64_t{0}})
    expectRefused(ErrorCode::kFormat, [&](auto& nodes) { nodes[0].key.value = key; });
}

TEST(HierarchyPage, refusesNodesOfAnotherSubtree) {
  const HierarchyPage page = makePage({kOwner, false});
  EXPECT_THROW(decodePage(encodePage(page), kRootKey.child(3).child(4), false), Error);
  EXPECT_THROW(decodePage(encodePage(page), kRootKey, true), Error);
}

TEST(HierarchyPage, refusesTheOwnerItselfBelowTheRootPage) {
  expectRefused(ErrorCode::kFormat,
                [](auto& nodes) {
                  nodes.pop_back();
                  Node owner = nodes[0];
                  owner.key = kOwner;
                  nodes.insert(nodes.begin(), owner);
                },
                {kOwner, false, 1, 7});
}

TEST(HierarchyPage, refusesNodesMoreThanTwoLevelsDown) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes.back().key = nodes.back().key.child(0); });
}

TEST(HierarchyPage, refusesOwnersThatOwnNoPage) {
  const std::vector<std::byte> bytes = encodePage(makePage({kOwner, false}));
  for (const NodeKey owner : {kRootKey, kRootKey.child(3), kOwner.child(1), NodeKey{0}, NodeKey{2}})
    EXPECT_THROW(decodePage(bytes, owner, false), Error) << owner.value;
  EXPECT_THROW(decodePage(encodePage(makePage({})), kOwner, true), Error);
}

TEST(HierarchyPage, refusesAMissingChild) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes.pop_back(); });
}

TEST(HierarchyPage, refusesAChildThatTheMaskDoesNotName) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[1].child_mask = 0x7f; });
}

TEST(HierarchyPage, refusesNodesWithoutTheirParent) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) {
    nodes[0].child_mask = 0x7f;
    nodes.erase(nodes.begin() + 8);
  });
}

TEST(HierarchyPage, refusesAChildPageForChildrenInThisPage) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[1].child_page = {1, 100, {}}; });
}

TEST(HierarchyPage, refusesChildrenWithoutAPage) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes.back().child_mask = 1; });
}

TEST(HierarchyPage, refusesAPageWithoutChildren) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes.back().child_page = {1, 100, {}}; });
}

TEST(HierarchyPage, refusesChildrenBelowTheDeepestLevel) {
  NodeKey owner = kRootKey;
  while (owner.depth() < kMaxDepth - 2) owner = owner.child(1);
  expectRefused(ErrorCode::kFormat,
                [](auto& nodes) {
                  nodes.back().child_mask = 1;
                  nodes.back().child_page = {1, 100, {}};
                },
                {owner, false});
}

TEST(HierarchyPage, refusesABoxThatTheParentsDoesNotHold) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[5].box.min.y = 999; });
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes.back().box.max.z = kMaxLattice; });
}

TEST(HierarchyPage, refusesAnInvertedBox) {
  expectRefused(ErrorCode::kFormat,
                [](auto& nodes) { std::swap(nodes.back().box.min.x, nodes.back().box.max.x); });
}

TEST(HierarchyPage, refusesTrianglesWithoutABox) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes.back().box = {}; });
}

TEST(HierarchyPage, refusesErrorsThatFallToACoarserLod) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[0].lods[1].error_model = 99; });
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[0].lods[1].appearance_error_model = 49; });
}

TEST(HierarchyPage, refusesErrorsThatFallToTheParent) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes.back().lods.back().error_model = 26; });
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[2].lods.back().appearance_error_model = 51; });
}

TEST(HierarchyPage, refusesErrorsThatFallFromTheSourceLodToTheParent) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[1].far_lods = 1; }, {.far_lods = 2});
}

TEST(HierarchyPage, refusesFarLodsWithoutAParentOrAReduction) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[0].far_lods = 1; });
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes.back().far_lods = 1; });
  expectRefused(ErrorCode::kLimit, [](auto& nodes) { nodes[1].far_lods = 2; });
}

TEST(HierarchyPage, refusesInvalidErrors) {
  for (const float error : {-1.0f, -0.0f, std::numeric_limits<float>::infinity(), std::nanf("")})
    expectRefused(ErrorCode::kFormat, [&](auto& nodes) { nodes[0].lods[1].error_model = error; });
}

TEST(HierarchyPage, refusesANodeWithoutLods) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[0].lods.clear(); });
}

TEST(HierarchyPage, refusesPayloadsWithoutTriangles) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[0].lods[0].triangles = 0; });
}

TEST(HierarchyPage, refusesPayloadsWithoutBytes) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[0].lods[0].payload.bytes = 0; });
}

TEST(HierarchyPage, refusesVerticesThatDoNotFitTheTriangles) {
  expectRefused(ErrorCode::kFormat, [](auto& nodes) { nodes[0].lods[0].vertices = 2; });
  expectRefused(ErrorCode::kFormat,
                [](auto& nodes) { nodes[0].lods[0].vertices = 3 * nodes[0].lods[0].triangles + 1; });
  expectRefused(ErrorCode::kFormat,
                [](auto& nodes) { nodes[0].lods[0].locked = nodes[0].lods[0].vertices + 1; });
}

TEST(HierarchyPage, refusesCountsAboveTheLimits) {
  const auto spoil = [](auto change) {
    return [change](std::vector<Node>& nodes) { change(nodes[0].lods[0]); };
  };
  expectRefused(ErrorCode::kLimit, spoil([](Lod& lod) { lod.triangles = kMaxLodTriangles + 1; }));
  expectRefused(ErrorCode::kLimit, spoil([](Lod& lod) { lod.vertices = kMaxLodVertices + 1; }));
  expectRefused(ErrorCode::kLimit, spoil([](Lod& lod) { lod.payload.bytes = kMaxBlobBytes + 1; }));
  expectRefused(ErrorCode::kLimit,
                [](auto& nodes) { nodes[0].lods.resize(kMaxLods + 1, nodes[0].lods.back()); });
  expectRefused(ErrorCode::kLimit, [](auto& nodes) { nodes.back().child_page = {1, kMaxPageBytes + 1, {}}; });
}

TEST(HierarchyPage, acceptsTheMostLodsAndRefusesOneMore) {
  expectRoundTrip({.children = 0, .lods = kMaxLods});
  expectRefused(ErrorCode::kLimit, [](auto& nodes) { nodes[0].lods.push_back(nodes[0].lods.back()); },
                {.children = 0, .lods = kMaxLods});
}

TEST(HierarchyPage, refusesMoreNodesThanItsKindHolds) {
  std::vector<std::byte> bytes(10000, std::byte{1});
  bytes[0] = encodePage({}).front();  // format version
  for (const bool is_root_page : {false, true}) {
    bytes[1] = static_cast<std::byte>(is_root_page ? 74 : 73);
    try {
      decodePage(bytes, is_root_page ? kRootKey : kOwner, is_root_page);
      FAIL() << "accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kLimit);
    }
  }
}

TEST(HierarchyPage, refusesAnEmptyPage) {
  EXPECT_THROW(decodePage(encodePage({}), kRootKey, true), Error);
  EXPECT_THROW(decodePage(encodePage({}), kOwner, false), Error);
}

TEST(HierarchyPage, refusesTooManyBytes) {
  EXPECT_THROW(decodePage(std::vector<std::byte>(kMaxPageBytes + 1), kRootKey, true), Error);
}

TEST(HierarchyPage, refusesToEncodeMoreThanAPageHolds) {
  EXPECT_THROW(encodePage(makePage({.lods = kMaxLods})), Error);
  HierarchyPage page = makePage({});
  page.nodes.push_back(page.nodes.back());
  EXPECT_THROW(encodePage(page), Error);
}

TEST(HierarchyPage, refusesNumbersThatAreNotInTheirShortestForm) {
  std::vector<std::byte> bytes = encodePage(makePage({.children = 0}));
  bytes[1] = std::byte{0x81};  // encodes the number of nodes, 1, in two bytes
  bytes.insert(bytes.begin() + 2, std::byte{0});
  EXPECT_THROW(decodePage(bytes, kRootKey, true), Error);
}

}  // namespace
}  // namespace lode
