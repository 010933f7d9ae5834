#include "client/app/window/camera/camera_path_writer.h"

#include <gtest/gtest.h>

namespace lode::core {
namespace {

TEST(CameraPathWriter, writesWhatIsReadBackAsTheSamePath) {
  CameraPath path;
  path.fov_y_deg = 33.3;
  path.keys = {{0, {1e6 + 0.1, 2, 3}, {0.1, -5, 1e-9}, {0, 0, 1}}, {0.1, {1, 2, 3}, {4, 5, 6}, {0, 1, 0}}};
  const CameraPath again = parseCameraPath(writeCameraPath(path), "p");
  EXPECT_EQ(again.fov_y_deg, path.fov_y_deg);
  EXPECT_EQ(again.keys, path.keys);
}

}  // namespace
}  // namespace lode::core
