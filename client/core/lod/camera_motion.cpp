#include "client/core/lod/camera_motion.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/quaternion.hpp>

namespace lode::core {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr Seconds kWindow{0.25};       // duration of the recorded history
constexpr Seconds kShortest{0.03};     // shorter histories give no reliable velocity
constexpr double kLargestTurnRad = 1;  // a larger rotation within the history counts as a jump

/// Returns the rotation from the camera's axes (right, up, back) to the model's axes.
glm::dquat axesOf(const View& view) {
  return glm::quat_cast(glm::dmat3(glm::cross(view.forward, view.up), view.up, -view.forward));
}

/// Returns a rotation with its angle multiplied by a factor.
glm::dquat scaled(const glm::dquat& turn, double factor) {
  const double angle = glm::angle(turn);
  if (angle < 1e-9) return {1, 0, 0, 0};
  return glm::angleAxis(angle * factor, glm::axis(turn));
}

bool isSamePicture(const View& a, const View& b) {
  return a.fov_y_rad == b.fov_y_rad && a.width_px == b.width_px && a.height_px == b.height_px;
}

}  // namespace

void CameraMotion::record(const View& view, TimePoint now) {
  if (!seen_.empty() && !isSamePicture(seen_.back().view, view)) seen_.clear();
  const size_t count = seen_.size();
  if (count >= 2 && seen_[count - 1].view == view && seen_[count - 2].view == view)
    seen_.back().at = now;
  else
    seen_.push_back({view, now});
  // Keep one entry that is older than the window, so that the history spans the whole window.
  while (seen_.size() > 2 && now - seen_[1].at > kWindow) seen_.pop_front();
}

std::optional<View> CameraMotion::predict(TimePoint now, Seconds ahead) const {
  if (seen_.size() < 2) return std::nullopt;
  const Seen& first = seen_.front();
  const Seen& last = seen_.back();
  const Seconds passed = last.at - first.at;
  if (passed < kShortest || passed > 2 * kWindow || now - last.at > kWindow) return std::nullopt;
  if (first.view == last.view) return std::nullopt;

  const glm::dquat from = axesOf(first.view), to = axesOf(last.view);
  glm::dquat turn = to * glm::conjugate(from);  // rotation between the two views, in the model frame
  if (turn.w < 0) turn = -turn;
  if (glm::angle(turn) > kLargestTurnRad) return std::nullopt;
  const double factor = (ahead + (now - last.at)) / passed;
  const glm::dvec3 path_model = last.view.eye_model - first.view.eye_model;
  // Treat the recorded and the predicted path as arcs of one circle. Rotate the recorded chord by the mean of
  // the arcs' angles, and scale it to the length of the predicted chord.
  const double angle = glm::angle(turn);
  const double stretch =
      angle < 1e-6 ? factor : std::sin(std::min(angle * factor, 3.0) / 2) / std::sin(angle / 2);

  View view = last.view;
  view.eye_model += scaled(turn, (1 + factor) / 2) * path_model * stretch;
  const glm::dquat turned = scaled(turn, factor);
  view.forward = glm::normalize(turned * last.view.forward);
  view.up =
      glm::normalize(turned * last.view.up - view.forward * glm::dot(view.forward, turned * last.view.up));
  return view;
}

}  // namespace lode::core
