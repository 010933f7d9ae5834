#pragma once

#include <glm/glm.hpp>

#include "client/app/window/input.h"
#include "client/core/camera_path.h"
#include "client/render/cameras.h"
#include "common/model_summary.h"

namespace lode::app {

/// The camera of the window: orbits or flies, whichever the user chose, and goes on from where it is when
/// that changes.
class CameraRig {
 public:
  /// @param path  its first key is where the camera starts.
  CameraRig(const core::CameraPath& path, const ModelSummary& model, uint32_t width_px, uint32_t height_px);

  void apply(const Input& input, double seconds);
  void resize(uint32_t width_px, uint32_t height_px) noexcept;

  const core::View& view() const noexcept { return view_; }
  bool flying() const noexcept { return flying_; }

 private:
  void restart(const core::View& from, double distance_model);

  core::View start_, view_;
  double start_distance_model_, model_size_;
  glm::dvec3 axis_;
  bool flying_ = false;
  render::OrbitCamera orbit_;
  render::FlyCamera fly_;
};

}  // namespace lode::app
