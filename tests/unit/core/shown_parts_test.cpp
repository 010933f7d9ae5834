#include <gtest/gtest.h>

#include "client/core/lod/cut.h"
#include "tests/unit/core/scripted_client.h"

namespace lode::core {
namespace {

using namespace fixture;
using Numbers = std::vector<uint32_t>;

constexpr NodeKey kNearNode = kRootKey.child(0), kFarNode = kRootKey.child(7);

/// Octants 1 and 2 of one child of the root, and octant 0 of another; all others are left out.
class ShownParts : public testing::Test {
 protected:
  ShownParts() {
    for (const NodeKey node : {kNearNode.child(1), kNearNode.child(2), kFarNode.child(0)})
      cut_.parts.push_back({node, 0, true, 1, nullptr});
    cut_.left_out = {{kNearNode.child(3), boxAt({1000, 0, 0})}, {kRootKey.child(6), boxAt({0, 1000, 0})}};
    cut_.fallbacks = {{{kNearNode, 0, false, 2, nullptr}, 0, 2, 0, 1, 0},
                      {{kRootKey, 0, false, 4, nullptr}, 0, 3, 1, 2, 0}};
  }

  static ModelBox boxAt(glm::dvec3 corner) { return {corner, corner + 10.0}; }

  Numbers shownTo(const View& view) const { return shownParts(cut_, view); }

  static constexpr uint32_t kNearFallback = 3, kRootFallback = 4;
  const View nowhere_ = lookingAt({0, 0, 0}, {0, 0, 1000}), at_near_ = lookingAt({0, 0, 0}, {1000, 0, 0}),
             at_root_ = lookingAt({0, 0, 0}, {0, 1000, 0}),
             at_both_ = lookingAt({2000, 2000, 0}, {500, 500, 0});
  Cut cut_;
};

TEST_F(ShownParts, areThePartsOfTheCutIfNoLeftOutNodeIsVisible) {
  EXPECT_EQ(shownTo(nowhere_), (Numbers{0, 1, 2}));
  EXPECT_EQ(countHoles(cut_, shownTo(nowhere_), nowhere_), 0u);
}

TEST_F(ShownParts, areTheNearestAncestorWhereSomethingIsLeftOut) {
  EXPECT_EQ(shownTo(at_near_), (Numbers{kNearFallback, 2}));
  EXPECT_EQ(countHoles(cut_, shownTo(at_near_), at_near_), 0u);
}

TEST_F(ShownParts, areTheOuterOfTwoAncestorsWhereBothAreNeeded) {
  EXPECT_EQ(shownTo(at_root_), Numbers{kRootFallback});
  EXPECT_EQ(shownTo(at_both_), Numbers{kRootFallback});
  EXPECT_EQ(countHoles(cut_, shownTo(at_both_), at_both_), 0u);
}

TEST_F(ShownParts, areOneAncestorForARegionWithoutParts) {
  cut_.parts.erase(cut_.parts.begin(), cut_.parts.begin() + 2);
  cut_.fallbacks[0].end_part = 0;
  cut_.fallbacks[1].end_part = 1;
  EXPECT_EQ(shownTo(at_near_), (Numbers{1, 0}));
  EXPECT_EQ(shownTo(at_both_), Numbers{2});
}

TEST_F(ShownParts, areTheInnermostSufficientOfThreeAncestors) {
  const NodeKey below = kNearNode.child(1);
  cut_.parts[0].node = below.child(0);
  cut_.left_out.insert(cut_.left_out.begin(), {below.child(7), boxAt({0, 0, -1000})});
  cut_.fallbacks = {{{below, 0, false, 1, nullptr}, 0, 1, 0, 1, 0},
                    {{kNearNode, 0, false, 2, nullptr}, 0, 2, 1, 2, 0},
                    {{kRootKey, 0, false, 4, nullptr}, 0, 3, 2, 3, 0}};
  const View at_below = lookingAt({0, 0, 0}, {0, 0, -1000});
  View at_below_and_near = lookingAt({2000, 0, 2000}, {500, 0, -500});
  at_below_and_near.fov_y_rad = 0.3;
  EXPECT_EQ(shownTo(nowhere_), (Numbers{0, 1, 2}));
  EXPECT_EQ(shownTo(at_below), (Numbers{3, 1, 2}));
  EXPECT_EQ(shownTo(at_near_), (Numbers{4, 2}));
  EXPECT_EQ(shownTo(at_below_and_near), (Numbers{4, 2}));
  EXPECT_EQ(shownTo(at_root_), Numbers{5});
  for (const View& view : {nowhere_, at_below, at_near_, at_below_and_near, at_root_})
    EXPECT_EQ(countHoles(cut_, shownTo(view), view), 0u);
}

TEST_F(ShownParts, countHolesIfTheCutAloneIsDrawn) {
  const Numbers all{0, 1, 2};
  EXPECT_EQ(countHoles(cut_, all, nowhere_), 0u);
  EXPECT_EQ(countHoles(cut_, all, at_near_), 1u);
  EXPECT_EQ(countHoles(cut_, all, at_both_), 2u);
  EXPECT_EQ(countHoles(cut_, Numbers{kNearFallback, 2}, at_both_), 1u);
}

/// A cut of one part with a side of 100 and an error of 1.
class ShownError : public testing::Test {
 protected:
  ShownError() {
    CutPart& part = cut_.parts.emplace_back();
    part.off_model = 1;
    part.box = {{0, 0, 0}, {100, 100, 100}};
  }
  float errorPx(const View& view) const { return shownErrorPx(cut_, Numbers{0}, view); }

  Cut cut_;
};

TEST_F(ShownError, growsAsTheCameraApproaches) {
  const float far_px = errorPx(lookingAt({50, 50, 1100}, {50, 50, 0}));
  EXPECT_GT(far_px, 0);
  EXPECT_NEAR(errorPx(lookingAt({50, 50, 200}, {50, 50, 0})), 10 * far_px, 0.01f * far_px);
}

TEST_F(ShownError, isZeroOutsideThePicture) {
  EXPECT_EQ(errorPx(lookingAt({50, 50, 1100}, {50, 50, 2000})), 0);
}

}  // namespace
}  // namespace lode::core
