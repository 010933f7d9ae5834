#include <gtest/gtest.h>

#include "client/app/camera/input.h"

namespace lode::app {
namespace {

TEST(Gamepad, doesNotMoveInsideTheDeadZone) {
  const PadMotion motion = motionOf({.left = {0.1, -0.15}, .right = {-0.1, 0.1}, .left_trigger = -0.9});
  EXPECT_EQ(motion.move.right, 0);
  EXPECT_EQ(motion.move.forward, 0);
  EXPECT_EQ(motion.move.up, 0);
  EXPECT_EQ(motion.turn, glm::dvec2(0));
}

TEST(Gamepad, movesAtFullSpeedWhereAStickIsPushedToItsEnd) {
  EXPECT_DOUBLE_EQ(motionOf({.left = {0, -1}}).move.forward, 1);
  EXPECT_DOUBLE_EQ(motionOf({.left = {1, 0}}).move.right, 1);
  EXPECT_DOUBLE_EQ(motionOf({.right = {-1, 0}}).turn.x, -1);
  EXPECT_DOUBLE_EQ(motionOf({.right_trigger = 1}).move.up, 1);
  EXPECT_DOUBLE_EQ(motionOf({.left_trigger = 1}).move.up, -1);
}

TEST(Gamepad, isNoFasterInASticksCornerThanAtItsSide) {
  const PadMotion motion = motionOf({.left = {1, -1}});
  EXPECT_NEAR(glm::length(glm::dvec2(motion.move.right, motion.move.forward)), 1, 1e-12);
}

TEST(Gamepad, keepsTheDirectionOfAStick) {
  const PadMotion motion = motionOf({.right = {0.6, 0.3}});
  EXPECT_NEAR(motion.turn.x / motion.turn.y, 2, 1e-12);
}

TEST(Gamepad, beginsToMoveWithoutAJumpAtTheEdgeOfTheDeadZone) {
  double before = 0;
  for (double x = 0; x <= 1; x += 0.01) {
    const double now = motionOf({.left = {x, 0}}).move.right;
    EXPECT_GE(now, before);
    EXPECT_LT(now - before, 0.03);
    before = now;
  }
}

}  // namespace
}  // namespace lode::app
