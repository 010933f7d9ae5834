#include "client/app/window/settings.h"

#include <gtest/gtest.h>

#include "client/render/passes/draw_style.h"

namespace lode::app {
namespace {

using render::ColorMode;

TEST(Settings, haveTheMemoryStepThatIsNearestByItsRatio) {
  EXPECT_EQ(kMemorySteps[memoryStepAt(uint64_t{1} << 30)], 1'000'000'000u);
  EXPECT_EQ(kMemorySteps[memoryStepAt(1'500'000'000)], 2'000'000'000u);
  EXPECT_EQ(memoryStepAt(1), 0u);
  EXPECT_EQ(memoryStepAt(uint64_t{1} << 50), kMemorySteps.size() - 1);
  for (size_t step = 0; step < kMemorySteps.size(); ++step) EXPECT_EQ(memoryStepAt(kMemorySteps[step]), step);
}

TEST(ColorModeSwitch, goesRoundInBothDirections) {
  ColorModeSwitch show(ColorMode::kSurface);
  show.step(-1);
  EXPECT_EQ(show.shown(), render::colorModes().back().mode);
  show.step(1 + static_cast<int>(render::colorModes().size()));
  EXPECT_EQ(show.shown(), ColorMode::kSurface);
}

TEST(ColorModeSwitch, returnsFromTheWireframeToThePreviousMode) {
  ColorModeSwitch show(ColorMode::kLods);
  show.toggleWireframe();
  EXPECT_EQ(show.shown(), ColorMode::kWireframe);
  show.toggleWireframe();
  EXPECT_EQ(show.shown(), ColorMode::kLods);
}

TEST(ColorModeSwitch, switchesFromAnInitialWireframeToTheSurface) {
  ColorModeSwitch show(ColorMode::kWireframe);
  show.toggleWireframe();
  EXPECT_EQ(show.shown(), ColorMode::kSurface);
}

TEST(ColorModeSwitch, stepsFromAnyModeThroughClayAndMatcapToTheSurface) {
  ColorModeSwitch show(ColorMode::kLods);
  for (const ColorMode wanted :
       {ColorMode::kClay, ColorMode::kMatcap, ColorMode::kSurface, ColorMode::kClay}) {
    show.nextClay();
    EXPECT_EQ(show.shown(), wanted);
  }
}

TEST(Settings, beginWithTheBackgroundOfEveryPicture) {
  const render::DrawStyle style;
  EXPECT_EQ(kBackgrounds[0].top_srgb, style.background_top_srgb);
  EXPECT_EQ(kBackgrounds[0].bottom_srgb, style.background_bottom_srgb);
}

}  // namespace
}  // namespace lode::app
