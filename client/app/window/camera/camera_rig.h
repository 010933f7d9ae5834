#pragma once

#include <array>
#include <optional>

#include <glm/glm.hpp>

#include "client/app/window/camera/camera_kind.h"
#include "client/app/window/camera/cameras.h"
#include "client/app/window/camera/walk_camera.h"
#include "client/app/window/input.h"
#include "client/core/view/camera_path.h"
#include "client/core/view/framing.h"
#include "common/codec/model_summary.h"

namespace lode::app {

/// The camera of the window: orbits, flies or walks, whichever the user chose, and goes on from where it is
/// when that changes.
class CameraRig {
 public:
  /// @param model    is looked at again whenever a camera begins: its box may have grown.
  /// @param framing  says what is up, whatever the path's cameras have as theirs.
  /// @param path     its first key is where the camera starts, and what is seen, leaning too, until it is
  ///                 moved; nothing: the camera that frames the model.
  CameraRig(const ModelSummary& model, core::Framing framing, const std::optional<core::CameraPath>& path,
            uint32_t width_px, uint32_t height_px);

  /// @param ground  where it walks.
  void apply(const Input& input, double seconds, const render::GroundBelow& ground);
  /// If it walks: goes on from above this point, and looks ahead on the level.
  void standAt(const glm::dvec3& point_model);
  /// Where it is, in true coordinates, at t = 0.
  core::CameraKey camera() const;
  /// Looks from elsewhere, and goes on from there. @param camera  in true coordinates.
  void lookFrom(const core::CameraKey& camera, double fov_y_deg);
  /// An orbit turns about this point from now on; the view stays.
  void turnAbout(const glm::dvec3& point_model) noexcept { orbit_.turnAbout(point_model); }
  /// An orbit comes nearer to this point, in a moment.
  void flyTo(const glm::dvec3& point_model) noexcept { orbit_.flyTo(point_model); }
  void resize(uint32_t width_px, uint32_t height_px) noexcept;
  /// When it frames the model again, it does so beside what covers so much of the picture: see core::Framing.
  void frameBeside(double covered) noexcept { framing_.covered = covered; }

  const core::View& view() const noexcept { return view_; }
  CameraKind kind() const noexcept { return kind_; }
  /// It moves without anybody's doing.
  bool underWay() const noexcept {
    return kind_ == CameraKind::kOrbit ? orbit_.isFlying() : kind_ == CameraKind::kWalk && walk_.isSettling();
  }
  const glm::dvec3& up() const noexcept { return up_; }
  /// @param number  1 to 9.
  bool hasBookmark(int number) const noexcept {
    return bookmarks_[static_cast<size_t>(number) - 1].has_value();
  }

 private:
  void startAt(const core::CameraPath& path);
  void frame();
  void startAgain();
  void restart(core::View from, double distance_model);
  void turnUp();
  bool isSteered(const Input& input) const noexcept;
  void useBookmark(size_t number, bool set);

  const ModelSummary& model_;
  core::Framing framing_;
  core::View start_, view_;
  double start_distance_model_ = 0;
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
  render::OrbitCamera orbit_{core::View{}, 1, {0, 1, 0}};
  render::FlyCamera fly_{core::View{}, 1, {0, 1, 0}};
  render::WalkCamera walk_{core::View{}, 1, {0, 1, 0}};
};

}  // namespace lode::app
