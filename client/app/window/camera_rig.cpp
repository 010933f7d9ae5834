#include "client/app/window/camera_rig.h"

#include <algorithm>

namespace lode::app {
namespace {

constexpr double kCrossingSeconds = 4;  ///< in which a flight at first speed passes the whole model

/// The coordinate axis nearest to a direction, with its sign.
glm::dvec3 nearestAxis(glm::dvec3 direction) {
  const glm::dvec3 size = glm::abs(direction);
  const int axis = size.x > size.y && size.x > size.z ? 0 : size.y >= size.z ? 1 : 2;
  glm::dvec3 result(0);
  result[axis] = direction[axis] < 0 ? -1 : 1;
  return result;
}

double sizeOf(const ModelSummary& model) {
  if (model.box.empty()) return model.lattice.step;
  const glm::dvec3 extent = glm::dvec3(model.box.max) - glm::dvec3(model.box.min);
  return std::max(glm::length(extent), 1.0) * model.lattice.step;
}

}  // namespace

CameraRig::CameraRig(const core::CameraPath& path, const ModelSummary& model, uint32_t width_px,
                     uint32_t height_px)
    : start_(core::toView(path.keys.front(), path.fov_y_deg, width_px, height_px, model)),
      view_(start_),
      start_distance_model_(glm::distance(path.keys.front().eye, path.keys.front().target)),
      model_size_(sizeOf(model)),
      axis_(nearestAxis(path.keys.front().up)),
      orbit_(start_, std::max(start_distance_model_, model.lattice.step), axis_),
      fly_(start_, model_size_ / kCrossingSeconds, axis_) {}

/// Both cameras go on from a view; the orbit turns about what lies so far ahead.
void CameraRig::restart(const core::View& from, double distance_model) {
  orbit_ = render::OrbitCamera(from, distance_model, axis_);
  fly_ = render::FlyCamera(from, model_size_ / kCrossingSeconds, axis_);
}

void CameraRig::apply(const Input& input, double seconds) {
  if (input.reset_camera) restart(start_, start_distance_model_);
  if (input.next_axis) {
    axis_ = glm::dvec3(axis_.z, axis_.x, axis_.y);
    restart(view_, orbit_.distanceModel());
  }
  if (input.toggle_camera) {
    restart(view_, orbit_.distanceModel());
    flying_ = !flying_;
  }
  if (flying_) {
    fly_.changeSpeed(input.wheel);
    fly_.look(input.turned_px + input.shifted_px, view_);
    fly_.move(input.fly, seconds);
    fly_.apply(view_);
  } else {
    orbit_.zoom(input.wheel);
    orbit_.drag(input.turned_px, view_.height_px);
    orbit_.shift(input.shifted_px, view_);
    orbit_.apply(view_);
  }
}

void CameraRig::resize(uint32_t width_px, uint32_t height_px) noexcept {
  view_.width_px = width_px;
  view_.height_px = height_px;
}

}  // namespace lode::app
