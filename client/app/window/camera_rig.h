#pragma once

#include <array>
#include <optional>

#include <glm/glm.hpp>

#include "client/app/window/input.h"
#include "client/core/camera_path.h"
#include "client/core/framing.h"
#include "client/render/cameras.h"
#include "common/model_summary.h"

namespace lode::app {

/// The camera of the window: orbits or flies, whichever the user chose, and goes on from where it is when
/// that changes.
class CameraRig {
 public:
  /// @param path  its first key is where the camera starts; nothing: the camera that frames the model.
  CameraRig(const ModelSummary& model, core::Framing framing, const std::optional<core::CameraPath>& path,
            uint32_t width_px, uint32_t height_px);

  void apply(const Input& input, double seconds);
  /// An orbit turns about this point from now on; the view stays.
  void turnAbout(const glm::dvec3& point_model) noexcept { orbit_.turnAbout(point_model); }
  /// An orbit comes nearer to this point, in a moment.
  void flyTo(const glm::dvec3& point_model) noexcept { orbit_.flyTo(point_model); }
  void resize(uint32_t width_px, uint32_t height_px) noexcept;

  const core::View& view() const noexcept { return view_; }
  bool flying() const noexcept { return flying_; }
  /// Of what it looks at, along the view.
  double distanceModel() const noexcept { return orbit_.distanceModel(); }
  /// It moves without anybody's doing.
  bool underWay() const noexcept { return !flying_ && orbit_.isFlying(); }
  const glm::dvec3& up() const noexcept { return up_; }

 private:
  void startAt(const core::CameraPath& path);
  void restart(const core::View& from, double distance_model);
  void turnUp();
  void useBookmark(size_t number, bool set);

  const ModelSummary& model_;
  core::Framing framing_;
  double model_size_;
  core::View start_, view_;
  double start_distance_model_ = 0;
  glm::dvec3 up_{0, 1, 0};
  bool flying_ = false;
  struct Bookmark {
    core::View view;
    double distance_model;
    glm::dvec3 up;
  };
  std::array<std::optional<Bookmark>, 9> bookmarks_;
  render::OrbitCamera orbit_{core::View{}, 1, {0, 1, 0}};
  render::FlyCamera fly_{core::View{}, 1, {0, 1, 0}};
};

}  // namespace lode::app
