#include "client/app/window/color_mode_switch.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using render::ColorMode;

TEST(ColorModeSwitch, goesRoundInBothDirections) {
  ColorModeSwitch show(ColorMode::kSurface);
  show.step(-1);
  EXPECT_EQ(static_cast<int>(show.shown()), render::kColorModeCount - 1);
  show.step(1 + render::kColorModeCount);
  EXPECT_EQ(show.shown(), ColorMode::kSurface);
}

TEST(ColorModeSwitch, goesBackFromTheWireframeToWhatWasShown) {
  ColorModeSwitch show(ColorMode::kLods);
  show.toggleWireframe();
  EXPECT_EQ(show.shown(), ColorMode::kWireframe);
  show.toggleWireframe();
  EXPECT_EQ(show.shown(), ColorMode::kLods);
}

TEST(ColorModeSwitch, goesToTheSurfaceFromAWireframeThatWasThereFirst) {
  ColorModeSwitch show(ColorMode::kWireframe);
  show.toggleWireframe();
  EXPECT_EQ(show.shown(), ColorMode::kSurface);
}

}  // namespace
}  // namespace lode::app
