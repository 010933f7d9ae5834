#include "client/app/window/show_switch.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using render::Show;

TEST(ShowSwitch, goesRoundInBothDirections) {
  ShowSwitch show(Show::kSurface);
  show.step(-1);
  EXPECT_EQ(static_cast<int>(show.shown()), render::kShowCount - 1);
  show.step(1 + render::kShowCount);
  EXPECT_EQ(show.shown(), Show::kSurface);
}

TEST(ShowSwitch, goesBackFromTheWireframeToWhatWasShown) {
  ShowSwitch show(Show::kLods);
  show.toggleWireframe();
  EXPECT_EQ(show.shown(), Show::kWireframe);
  show.toggleWireframe();
  EXPECT_EQ(show.shown(), Show::kLods);
}

TEST(ShowSwitch, goesToTheSurfaceFromAWireframeThatWasThereFirst) {
  ShowSwitch show(Show::kWireframe);
  show.toggleWireframe();
  EXPECT_EQ(show.shown(), Show::kSurface);
}

}  // namespace
}  // namespace lode::app
