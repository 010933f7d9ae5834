#include "client/app/window/camera/path_recorder.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(PathRecorder, notesACameraEveryTenthOfASecondFromItsFirst) {
  PathRecorder recorder;
  recorder.start();
  const core::CameraKey camera{0, {1, 2, 3}, {0, 0, 0}, {0, 0, 1}};
  for (const double t_s : {7.0, 7.05, 7.125, 7.2, 7.25}) recorder.see(t_s, camera, 40);
  const auto path = recorder.finish();
  ASSERT_TRUE(path);
  EXPECT_EQ(path->fov_y_deg, 40);
  ASSERT_EQ(path->keys.size(), 3u);
  EXPECT_EQ(path->keys[1].t, 0.125);
  EXPECT_EQ(path->keys[2].t, 0.25);
  EXPECT_EQ(path->keys[2].up, glm::dvec3(0, 0, 1));
}

TEST(PathRecorder, hasNoPathWhereItSawNothing) {
  PathRecorder recorder;
  recorder.see(0, {}, 45);
  EXPECT_FALSE(recorder.finish());
  recorder.start();
  EXPECT_TRUE(recorder.recording());
  EXPECT_FALSE(recorder.finish());
  EXPECT_FALSE(recorder.recording());
}

}  // namespace
}  // namespace lode::app
