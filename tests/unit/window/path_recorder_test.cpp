#include "client/app/window/path_recorder.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(PathRecorder, notesACameraEveryTenthOfASecondFromItsFirst) {
  PathRecorder recorder;
  recorder.start();
  const core::CameraKey camera{0, {1, 2, 3}, {0, 0, 0}, {0, 0, 1}};
  for (const double t_s : {7.0, 7.05, 7.125, 7.2, 7.25}) recorder.add(t_s, camera, 40);
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
  recorder.add(0, {}, 45);
  EXPECT_FALSE(recorder.finish());
  recorder.start();
  EXPECT_TRUE(recorder.recording());
  EXPECT_FALSE(recorder.finish());
  EXPECT_FALSE(recorder.recording());
}

TEST(CameraPathWriter, writesAPathThatReadsBackUnchanged) {
  core::CameraPath path;
  path.fov_y_deg = 33.3;
  path.keys = {{0, {1e6 + 0.1, 2, 3}, {0.1, -5, 1e-9}, {0, 0, 1}}, {0.1, {1, 2, 3}, {4, 5, 6}, {0, 1, 0}}};
  const core::CameraPath again = core::parseCameraPath(writeCameraPath(path), "p");
  EXPECT_EQ(again.fov_y_deg, path.fov_y_deg);
  EXPECT_EQ(again.keys, path.keys);
}

}  // namespace

}  // namespace lode::app
