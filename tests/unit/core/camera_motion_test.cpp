#include "client/core/lod/camera_motion.h"

#include <cmath>

#include <gtest/gtest.h>

namespace lode::core {
namespace {

using std::chrono::milliseconds;
using Seconds = std::chrono::duration<double>;

/// Returns a view from a helix around the origin, one turn in 20 seconds.
View onHelix(double t_s) {
  const double angle = 2 * 3.14159265358979 * t_s / 20;
  View view;
  view.eye_model = {100 * std::cos(angle), 2 * t_s, 100 * std::sin(angle)};
  view.forward = {-std::cos(angle), 0, -std::sin(angle)};
  view.up = {0, 1, 0};
  return view;
}

void watch(CameraMotion& motion, int from_ms, int to_ms, const auto& viewAt) {
  for (int ms = from_ms; ms <= to_ms; ms += 16)
    motion.record(viewAt(ms * 1e-3), TimePoint{} + milliseconds(ms));
}

TEST(CameraMotion, continuesAHelix) {
  CameraMotion motion;
  watch(motion, 0, 992, onHelix);
  const auto ahead = motion.predict(TimePoint{} + milliseconds(992), Seconds(1));
  ASSERT_TRUE(ahead);
  const View expected = onHelix(1.992);
  EXPECT_LT(glm::length(ahead->eye_model - expected.eye_model), 0.1);
  EXPECT_LT(glm::length(ahead->forward - expected.forward), 1e-3);
  EXPECT_LT(glm::length(ahead->up - expected.up), 1e-3);
}

TEST(CameraMotion, continuesAStraightLine) {
  CameraMotion motion;
  const auto viewAt = [](double t_s) {
    View view;
    view.eye_model = {3 * t_s, 0, -7 * t_s};
    return view;
  };
  watch(motion, 0, 480, viewAt);
  const auto ahead = motion.predict(TimePoint{} + milliseconds(500), Seconds(2));
  ASSERT_TRUE(ahead);
  EXPECT_LT(glm::length(ahead->eye_model - viewAt(2.5).eye_model), 1e-6);
}

TEST(CameraMotion, predictsNothingForAStandingCamera) {
  CameraMotion motion;
  watch(motion, 0, 2000, [](double) { return View(); });
  EXPECT_FALSE(motion.predict(TimePoint{} + milliseconds(2000), Seconds(1)));
}

TEST(CameraMotion, predictsNothingSoonAfterTheCameraStops) {
  CameraMotion motion;
  watch(motion, 0, 480, onHelix);
  watch(motion, 496, 1200, [](double) { return onHelix(0.48); });
  EXPECT_FALSE(motion.predict(TimePoint{} + milliseconds(1200), Seconds(1)));
}

TEST(CameraMotion, treatsALargeTurnAsAJump) {
  CameraMotion motion;
  watch(motion, 0, 480, onHelix);
  watch(motion, 496, 512, [](double) { return onHelix(8); });
  EXPECT_FALSE(motion.predict(TimePoint{} + milliseconds(512), Seconds(1)));
}

}  // namespace
}  // namespace lode::core
