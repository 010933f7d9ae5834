#pragma once

#include <array>
#include <optional>

#include <glm/glm.hpp>

#include "client/app/camera/cameras.h"
#include "client/app/camera/input.h"
#include "client/app/camera/walk_camera.h"
#include "client/core/view/camera_path.h"
#include "client/core/view/framing.h"
#include "common/codec/model_summary.h"

namespace lode::app {

/// Field of view of parallel projection.
constexpr double kParallelFovDeg = 0.1;

/// The camera of the window, which orbits, flies or walks, as the user chooses. The view stays the same when
/// the user switches between these.
class CameraRig {
 public:
  /// @param model    model or scene to look at; must outlive this object. The box of the model may grow, so
  ///                 the rig reads the box again whenever a camera starts.
  /// @param framing  framing with the up axis, which overrides the up axes of the path's cameras.
  /// @param path     path whose first key is the initial view. The roll of this view stays until the camera
  ///                 moves. Without a path, the initial view frames the model.
  CameraRig(const ModelSummary& model, core::Framing framing, const std::optional<core::CameraPath>& path,
            uint32_t width_px, uint32_t height_px);

  /// Applies the input of a frame. @param ground  finds the ground for the walking camera.
  void apply(const Input& input, double seconds, const GroundBelow& ground);
  /// Moves a walking camera above a point, with a horizontal view. Does nothing if the camera does not walk.
  void standAt(const glm::dvec3& point_model);
  /// Returns the camera at t = 0, in true coordinates (those of the model's file).
  core::CameraKey camera() const;
  /// Moves the view to a camera that is given in true coordinates.
  void lookFrom(const core::CameraKey& camera, double fov_y_deg);
  /// Looks squarely at a side of the whole model, with the orbiting camera.
  void lookAtSide(core::Side side);
  /// Switches between perspective and parallel projection, with the orbiting camera. The picture of the
  /// orbited point's plane stays the same. Parallel projection is a perspective with a field of view of
  /// kParallelFovDeg from far away, so that errors in pixels, picking and recorded paths need no other rules.
  /// At a depth of one picture height from the orbited point, a surface at the top of the picture is off by
  /// 0.09 % of the picture's height from an exact parallel projection.
  void toggleParallel();
  bool isParallel() const noexcept { return view_.fov_y_rad == glm::radians(kParallelFovDeg); }
  /// Locks or unlocks the field of view. While it is locked, a camera with another field of view moves along
  /// its view direction, so that the picture of the orbited point's plane stays the same. In parallel
  /// projection, only the orbiting camera is available.
  void holdFieldOfView(bool held) noexcept {
    held_fov_rad_ = held ? std::optional(view_.fov_y_rad) : std::nullopt;
  }
  /// Sets the point to orbit. The view stays the same.
  void turnAbout(const glm::dvec3& point_model) noexcept { orbit_.turnAbout(point_model); }
  /// Starts a flight of the orbit camera towards a point.
  void flyTo(const glm::dvec3& point_model) noexcept { orbit_.flyTo(point_model); }
  void resize(uint32_t width_px, uint32_t height_px) noexcept;
  /// Sets the share of the picture that the panel covers. A camera that frames the model keeps this share
  /// free: see core::Framing.
  void frameBeside(double covered) noexcept { framing_.covered = covered; }

  const core::View& view() const noexcept { return view_; }
  /// Returns the distance along the view direction to the point that the orbiting camera last orbited.
  double distanceModel() const noexcept { return orbit_.distanceModel(); }
  CameraKind kind() const noexcept { return kind_; }
  /// Returns true while the camera moves without input.
  bool isMoving() const noexcept {
    return kind_ == CameraKind::kOrbit ? orbit_.isFlying() : kind_ == CameraKind::kWalk && walk_.isSettling();
  }
  const glm::dvec3& up() const noexcept { return up_; }
  /// Returns true if the bookmark is set. @param number  1 to 9.
  bool hasBookmark(int number) const noexcept {
    return bookmarks_[static_cast<size_t>(number) - 1].has_value();
  }

 private:
  void startAt(const core::CameraPath& path);
  void frame();
  void orbitTheMiddle();
  void startAgain();
  void restart(core::View from, double distance_model);
  void turnUp();
  void leaveParallel();
  void changeFieldOfView(double fov_rad);
  void choose(const Input& input);
  void steer(const Input& input, double seconds, const GroundBelow& ground);
  bool isSteered(const Input& input) const noexcept;
  void useBookmark(size_t number, bool set);

  const ModelSummary& model_;
  core::Framing framing_;
  core::View start_, view_;
  double start_distance_model_ = 0;
  double perspective_fov_rad_ = core::View().fov_y_rad;  ///< last field of view of a perspective
  std::optional<double> held_fov_rad_;                   ///< set while holdFieldOfView() applies
  bool starts_framed_;
  glm::dvec3 up_;
  CameraKind kind_ = CameraKind::kOrbit;
  struct Bookmark {
    core::View view;
    double distance_model;
    glm::dvec3 up;
    CameraKind kind;
  };
  std::array<std::optional<Bookmark>, 9> bookmarks_;
  OrbitCamera orbit_{core::View{}, 1, {0, 1, 0}};
  FlyCamera fly_{core::View{}, 1, {0, 1, 0}};
  WalkCamera walk_{core::View{}, 1, {0, 1, 0}};
};

}  // namespace lode::app
