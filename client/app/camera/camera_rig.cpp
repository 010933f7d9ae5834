#include "client/app/camera/camera_rig.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace lode::app {
namespace {

/// Time that the flying camera takes to cross the model at its initial speed.
constexpr double kCrossingSeconds = 4;
/// Turning speed of a fully deflected stick, as a drag in picture heights per second.
constexpr double kPadHeightsPerSecond = 1.2;
/// Zooming speed of a fully deflected stick, or of W and S, in wheel steps per second.
constexpr double kPadStepsPerSecond = 6;
constexpr double kEyeHeight = 0.005;  ///< initial eye height, relative to the model's size
constexpr double kDropHeights = 2;  ///< height above the ground from which standAt() descends, in eye heights

double sizeOf(const ModelSummary& model) {
  if (model.box.empty()) return model.lattice.step;
  const glm::dvec3 extent = glm::dvec3(model.box.max) - glm::dvec3(model.box.min);
  return std::max(glm::length(extent), 1.0) * model.lattice.step;
}

}  // namespace

CameraRig::CameraRig(const ModelSummary& model, core::Framing framing,
                     const std::optional<core::CameraPath>& path, uint32_t width_px, uint32_t height_px)
    : model_(model), framing_(std::move(framing)), starts_framed_(!path), up_(core::upOf(framing_)) {
  resize(width_px, height_px);
  if (path)
    startAt(*path);
  else
    frame();
}

void CameraRig::startAt(const core::CameraPath& path) {
  const core::CameraKey& key = path.keys.front();
  start_ = core::toView(key, path.fov_y_deg, view_.width_px, view_.height_px, model_);
  start_distance_model_ = std::max(glm::distance(key.eye, key.target), model_.lattice.step);
  restart(start_, start_distance_model_);
}

/// Moves to the camera that frames the model in the window's current size.
void CameraRig::frame() {
  if (view_.width_px > 0 && view_.height_px > 0)
    framing_.aspect = static_cast<double>(view_.width_px) / view_.height_px;
  startAt(core::framingCamera(model_, framing_));
  orbitTheMiddle();
}

/// Orbits the centre of the model, which is not straight ahead if the panel covers a part of the picture.
void CameraRig::orbitTheMiddle() {
  const core::ModelBox box = core::toModelBox(model_.box, model_.lattice.step);
  if (framing_.covered > 0) turnAbout((box.min + box.max) / 2.0);
}

/// Restarts the orbiting, flying and walking cameras from a view. The orbited point lies straight ahead, at
/// the given distance.
void CameraRig::restart(core::View from, double distance_model) {
  from.width_px = view_.width_px;  // the size of the window may have changed
  from.height_px = view_.height_px;
  view_ = from;
  const double size = sizeOf(model_);  // the model's box may have grown
  orbit_ = OrbitCamera(from, distance_model, up_);
  fly_ = FlyCamera(from, size / kCrossingSeconds, up_);
  walk_ = WalkCamera(from, size * kEyeHeight, up_);
}

/// Returns the camera. Its up vector is the up axis, or the view's up if the view is rolled or looks along
/// the up axis.
core::CameraKey CameraRig::camera() const {
  constexpr double kAlong = 1e-5, kUpright = 1e-9;
  const glm::dvec3 eye = model_.lattice.origin + view_.eye_model;
  const glm::dvec3 level = glm::cross(view_.forward, up_);
  const bool is_upright = glm::length(level) > kAlong && std::abs(glm::dot(level, view_.up)) < kUpright &&
                          glm::dot(view_.up, up_) > 0;
  return {0, eye, eye + view_.forward * orbit_.distanceModel(), is_upright ? up_ : view_.up};
}

void CameraRig::lookFrom(const core::CameraKey& camera, double fov_y_deg) {
  restart(core::toView(camera, fov_y_deg, view_.width_px, view_.height_px, model_),
          std::max(glm::distance(camera.eye, camera.target), model_.lattice.step));
}

void CameraRig::standAt(const glm::dvec3& point_model) {
  if (kind_ != CameraKind::kWalk) return;
  core::View above = view_;
  above.eye_model = point_model + up_ * (walk_.eyeHeightModel() * kDropHeights);
  above.forward = Heading(view_, up_).level();
  walk_ = WalkCamera(above, walk_.eyeHeightModel(), up_);
}

/// Switches to the next up axis and frames the model.
void CameraRig::turnUp() {
  constexpr std::array<glm::dvec3, 6> kTurns{glm::dvec3{0, 1, 0}, {0, 0, 1},  {1, 0, 0},
                                             {0, -1, 0},          {0, 0, -1}, {-1, 0, 0}};
  // If z was a guess, switch to y, the other likely axis.
  const auto now = !framing_.up && up_ == kTurns[1] ? kTurns.end() - 1 : std::ranges::find(kTurns, up_);
  framing_.up = kTurns[static_cast<size_t>(now - kTurns.begin() + 1) % kTurns.size()];
  up_ = *framing_.up;
  starts_framed_ = true;
  frame();
}

void CameraRig::lookAtSide(core::Side side) {
  core::Framing framing = framing_;
  framing.up = up_;
  framing.side = side;
  framing.fov_y_deg = glm::degrees(view_.fov_y_rad);
  if (view_.width_px > 0 && view_.height_px > 0)
    framing.aspect = static_cast<double>(view_.width_px) / view_.height_px;
  const core::CameraPath path = core::framingCamera(model_, framing);
  const core::CameraKey& key = path.keys.front();
  kind_ = CameraKind::kOrbit;
  const bool was_parallel = isParallel();
  restart(core::toView(key, path.fov_y_deg, view_.width_px, view_.height_px, model_),
          std::max(glm::distance(key.eye, key.target), model_.lattice.step));
  if (was_parallel) view_.fov_y_rad = glm::radians(kParallelFovDeg);
  orbitTheMiddle();
}

void CameraRig::toggleParallel() {
  if (kind_ != CameraKind::kOrbit) restart(view_, orbit_.distanceModel());  // orbit what the camera looks at
  kind_ = CameraKind::kOrbit;
  if (!isParallel()) perspective_fov_rad_ = view_.fov_y_rad;
  changeFieldOfView(isParallel() ? perspective_fov_rad_ : glm::radians(kParallelFovDeg));
}

/// Changes the field of view and the distance, so that the picture of the orbited point's plane stays the
/// same.
void CameraRig::changeFieldOfView(double fov_rad) {
  const double ratio = std::tan(view_.fov_y_rad / 2) / std::tan(fov_rad / 2);
  const double distance_model = orbit_.distanceModel();
  const glm::dvec3 point_model = orbit_.pointModel();
  core::View view = view_;
  view.eye_model -= view.forward * (distance_model * (ratio - 1));
  view.fov_y_rad = fov_rad;
  restart(view, distance_model * ratio);
  orbit_.turnAbout(point_model);
}

/// Returns to perspective for a camera that moves through the model.
void CameraRig::leaveParallel() {
  if (isParallel()) toggleParallel();
}

void CameraRig::useBookmark(size_t number, bool set) {
  std::optional<Bookmark>& bookmark = bookmarks_[number - 1];
  if (set) bookmark = {view_, orbit_.distanceModel(), up_, kind_};
  if (set || !bookmark) return;
  up_ = bookmark->up;
  kind_ = bookmark->kind;
  restart(bookmark->view, bookmark->distance_model);
}

/// Returns true if the camera must be updated. A walking camera is always updated, because the ground may
/// change while it loads.
bool CameraRig::isSteered(const Input& input) const noexcept {
  return input.turned_px != glm::dvec2(0) || input.shifted_px != glm::dvec2(0) || input.wheel != 0 ||
         input.pad_turn != glm::dvec2(0) || input.fly.right != 0 || input.fly.up != 0 ||
         input.fly.forward != 0 || kind_ == CameraKind::kWalk || isMoving();
}

void CameraRig::startAgain() {
  leaveParallel();
  up_ = core::upOf(framing_);
  if (starts_framed_)
    frame();
  else
    restart(start_, start_distance_model_);
}

/// Applies the input of a frame. If nothing steers the camera, leaves the view as it is, because computing
/// the view again could round differently.
void CameraRig::apply(const Input& input, double seconds, const GroundBelow& ground) {
  choose(input);
  if (isSteered(input)) steer(input, seconds, ground);
}

/// Applies the keys that choose a view or a kind of camera.
void CameraRig::choose(const Input& input) {
  if (input.reset_camera) startAgain();
  for (int i = 0; i < input.next_axis; ++i) turnUp();
  if (input.bookmark != 0) useBookmark(static_cast<size_t>(input.bookmark), input.set_bookmark);
  if (input.toggle_parallel) toggleParallel();
  if (input.side) lookAtSide(*input.side);
  if (input.next_camera != 0) {
    leaveParallel();
    restart(view_, orbit_.distanceModel());
    kind_ = static_cast<CameraKind>((static_cast<int>(kind_) + input.next_camera) % kCameraKindCount);
  }
  if (!held_fov_rad_ || view_.fov_y_rad == *held_fov_rad_) return;
  changeFieldOfView(*held_fov_rad_);
  if (isParallel()) kind_ = CameraKind::kOrbit;
}

/// Moves the camera by drags, the wheel, keys that are held and the gamepad.
void CameraRig::steer(const Input& input, double seconds, const GroundBelow& ground) {
  const glm::dvec2 looked_px = input.turned_px + input.shifted_px -
                               input.pad_turn * (kPadHeightsPerSecond * seconds * view_.height_px);
  const auto move = [&](auto& camera, const auto&... where) {
    camera.changeSpeed(input.wheel);
    camera.look(looked_px, view_);
    camera.move(input.fly, seconds, where...);
    camera.apply(view_);
  };
  switch (kind_) {
    case CameraKind::kOrbit:
      orbit_.advance(seconds);
      orbit_.zoom(input.wheel + input.fly.forward * kPadStepsPerSecond * seconds);
      orbit_.drag(looked_px - input.shifted_px, view_.height_px);
      orbit_.shift(input.shifted_px, view_);
      orbit_.apply(view_);
      break;
    case CameraKind::kFly:
      move(fly_);
      break;
    case CameraKind::kWalk:
      move(walk_, ground);
      break;
  }
}

void CameraRig::resize(uint32_t width_px, uint32_t height_px) noexcept {
  view_.width_px = width_px;
  view_.height_px = height_px;
}

}  // namespace lode::app
