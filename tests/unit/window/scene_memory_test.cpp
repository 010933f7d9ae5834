#include "client/app/window/scene/scene_memory.h"

#include <numeric>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using Needs = std::vector<SceneMemory::Need>;

uint64_t sum(const std::vector<uint64_t>& parts) {
  return std::accumulate(parts.begin(), parts.end(), uint64_t{0});
}

TEST(SceneMemory, isSharedEquallyWhileNoModelIsShort) {
  SceneMemory memory(3000, 3);
  EXPECT_FALSE(memory.share(Needs{{900, false}, {10, false}, {1, false}}));
  EXPECT_EQ(memory.parts(), (std::vector<uint64_t>{1000, 1000, 1000}));
}

TEST(SceneMemory, goesToTheModelsThatNeedItIfOneIsShort) {
  SceneMemory memory(8000, 2);
  EXPECT_TRUE(memory.share(Needs{{9000, true}, {3000, false}}));
  EXPECT_NEAR(static_cast<double>(memory.parts()[0]), 500 + 7000 * 0.75, 2);
  EXPECT_NEAR(static_cast<double>(memory.parts()[1]), 500 + 7000 * 0.25, 2);
}

TEST(SceneMemory, leavesAShareToAModelThatNeedsNothing) {
  SceneMemory memory(8000, 2);
  EXPECT_TRUE(memory.share(Needs{{9000, true}, {0, false}}));
  EXPECT_GE(memory.parts()[1], 500u);
}

TEST(SceneMemory, neverExceedsTheBudget) {
  for (uint64_t first = 1; first < uint64_t{1} << 40; first *= 3) {
    SceneMemory memory((uint64_t{1} << 33) + 7, 3);
    memory.share(Needs{{first, true}, {12345678, true}, {first / 7, false}});
    EXPECT_LE(sum(memory.parts()), (uint64_t{1} << 33) + 7) << first;
  }
}

/// @return how often parts change in a hundred frames whose needs alternate.
int changesOf(SceneMemory& memory, const core::View& view, float threshold_px) {
  int changes = 0;
  for (int turn = 0; turn < 100; ++turn) {
    memory.setView(view, threshold_px);
    changes +=
        memory.share(turn % 2 == 0 ? Needs{{900, true}, {100, true}} : Needs{{100, true}, {900, true}});
  }
  return changes;
}

TEST(SceneMemory, settlesUntilThePictureChanges) {
  SceneMemory memory(8000, 2);
  core::View view;
  EXPECT_GT(changesOf(memory, view, 1), 1);
  EXPECT_EQ(changesOf(memory, view, 1), 0);
  view.eye_model.x += 1;
  EXPECT_GT(changesOf(memory, view, 1), 1);
  EXPECT_EQ(changesOf(memory, view, 1), 0);
  EXPECT_GT(changesOf(memory, view, 0.5f), 1) << "another threshold";
}

TEST(SceneMemory, changesInTheSamePictureForALateModel) {
  SceneMemory memory(8000, 2);
  changesOf(memory, core::View{}, 1);
  memory.allowChanges();
  EXPECT_GT(changesOf(memory, core::View{}, 1), 1);
}

TEST(SceneMemory, staysWhereNeedsHardlyDiffer) {
  SceneMemory memory(8000, 2);
  EXPECT_FALSE(memory.share(Needs{{510, true}, {500, true}}));
}

TEST(SceneMemory, givesEachModelTheGpuMemoryThatTheOthersLeave) {
  EXPECT_EQ(gpuBudgets(1000, std::vector<GpuShare>{{300, 600}, {300, 100}, {200, 50}}),
            (std::vector<uint64_t>{850, 350, 300}));
}

TEST(SceneMemory, leavesEachModelItsGpuShareAfterTheBudgetShrinks) {
  EXPECT_EQ(gpuBudgets(1000, std::vector<GpuShare>{{500, 1500}, {500, 1500}}),
            (std::vector<uint64_t>{500, 500}));
}

}  // namespace
}  // namespace lode::app
