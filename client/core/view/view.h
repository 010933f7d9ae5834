#pragma once

#include <array>
#include <cstdint>

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

/// How much of a box is in a picture, as far as planes tell.
enum class Seen : uint8_t { kNot, kPartly, kWholly };

/// What screenErrorPx() and boxMayBeVisible() say, for many boxes of one view, whose angles are worked out
/// once.
class Sight {
 public:
  /// @param widening  of what a view that turns a little may see.
  Sight(const View& view, double widening) noexcept;

  Seen see(const ModelBox& box) const noexcept { return picture_.see(box); }
  /// Of a box that it does not see.
  bool maySeeWhenTurned(const ModelBox& box) const noexcept { return wider_.see(box) != Seen::kNot; }
  double distanceTo(const ModelBox& box) const noexcept { return distanceToBox(eye_model_, box); }
  float errorPx(float error_model, double distance_model) const noexcept;

 private:
  /// The pyramid of a picture, by inward normals of its sides and of the plane through the eye.
  class Pyramid {
   public:
    Pyramid(const View& view, double widening) noexcept;
    Seen see(const ModelBox& box) const noexcept;

   private:
    glm::dvec3 eye_model_;
    std::array<glm::dvec3, 5> inward_;  // none needs unit length
    std::array<glm::dvec3, 5> reach_;   // the same without signs
  };

  glm::dvec3 eye_model_;
  double near_model_, focal_px_;
  Pyramid picture_, wider_;
};

}  // namespace lode::core
