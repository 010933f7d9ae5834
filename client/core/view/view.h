#pragma once

#include <glm/glm.hpp>

#include "common/lattice.h"

namespace lode::core {

/// A camera and the picture that it fills, in the model frame (true coordinates minus the lattice's origin),
/// in double.
struct View {
  glm::dvec3 eye_model{0, 0, 1};
  glm::dvec3 forward{0, 0, -1};  ///< unit length
  glm::dvec3 up{0, 1, 0};        ///< unit length, at a right angle to forward
  double fov_y_rad = 0.785398163397448;
  uint32_t width_px = 1280, height_px = 720;
  double near_model = 1e-6;  ///< distances below it count as it

  bool operator==(const View&) const = default;
};

/// Axis-aligned box in the model frame.
struct ModelBox {
  glm::dvec3 min{0}, max{0};
};

ModelBox toModelBox(const LatticeBox& box, double step) noexcept;

/// Eye to the nearest point of the box; 0 inside.
double distanceToBox(glm::dvec3 eye_model, const ModelBox& box) noexcept;

/// Projected size of a node's geometric error.
/// @param error_model     >= 0, in model units.
/// @param distance_model  eye to the nearest point of the node's box; clamped to view.near_model.
/// @return pixels; monotone in error_model: the refinement queue relies on it.
/// Source: Luebke et al., Level of Detail for 3D Graphics, 2003.
float screenErrorPx(float error_model, double distance_model, const View& view) noexcept;

/// Pixels that one unit takes up at a distance of one. By their ratio pixels of one picture become another's.
double focalPx(const View& view) noexcept;

/// False only if no point of the box can be in the picture (planes test: may say true for a box just
/// outside).
/// @param widening  of the picture, each side from its middle: 1.2 looks a fifth further on every side.
bool boxMayBeVisible(const ModelBox& box, const View& view, double widening = 1) noexcept;

}  // namespace lode::core
