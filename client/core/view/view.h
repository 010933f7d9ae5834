#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

#include "common/lattice.h"

namespace lode::core {

/// A camera and the size of its picture, in the model frame (true coordinates minus the lattice origin).
struct View {
  glm::dvec3 eye_model{0, 0, 1};
  glm::dvec3 forward{0, 0, -1};  ///< unit length
  glm::dvec3 up{0, 1, 0};        ///< unit length, perpendicular to forward
  double fov_y_rad = 0.785398163397448;
  uint32_t width_px = 1280, height_px = 720;
  double near_model = 1e-6;  ///< smaller distances are clamped to this distance

  bool operator==(const View&) const = default;
};

/// Axis-aligned box in the model frame.
struct ModelBox {
  glm::dvec3 min{0}, max{0};
};

ModelBox toModelBox(const LatticeBox& box, double step) noexcept;

/// Returns the distance from the eye to the nearest point of the box; 0 inside.
double distanceToBox(glm::dvec3 eye_model, const ModelBox& box) noexcept;

/// Projects a geometric error to pixels.
/// @param error_model     error in model units, at least 0.
/// @param distance_model  lower bound of the distance from the eye to the surface; clamped to
///                        view.near_model.
/// @return error in pixels. The error grows with error_model; the refinement queue relies on this.
/// Source: Luebke et al., Level of Detail for 3D Graphics, 2003.
float screenErrorPx(float error_model, double distance_model, const View& view) noexcept;

/// Returns the focal length in pixels: the projected size of one unit at distance one.
double focalPx(const View& view) noexcept;

/// Returns false only if the box is outside the picture. The test is conservative: the function can return
/// true for a box just outside the picture.
/// @param widening  scale of the picture about its centre; 1.2 makes the picture a fifth wider and higher.
bool boxMayBeVisible(const ModelBox& box, const View& view, double widening = 1) noexcept;

/// Result of a box test against the planes of a frustum.
enum class Visibility : uint8_t { kOutside, kPartial, kInside };

/// Computes screenErrorPx() and boxMayBeVisible() for many boxes, but the frustum of their common view only
/// once.
class ViewFrustum {
 public:
  /// @param widening  scale of the widened picture: see isInMargin().
  ViewFrustum(const View& view, double widening) noexcept;

  Visibility test(const ModelBox& box) const noexcept { return picture_.test(box); }
  /// Tests a box that is outside the picture. Returns true if it may be inside the widened picture.
  bool isInMargin(const ModelBox& box) const noexcept { return wider_.test(box) != Visibility::kOutside; }
  glm::dvec3 eyeModel() const noexcept { return eye_model_; }
  /// Inward normals of the planes that bound the picture, of unit length; all planes pass through the eye.
  std::array<glm::dvec3, 5> inwardNormals() const noexcept;
  double distanceTo(const ModelBox& box) const noexcept { return distanceToBox(eye_model_, box); }
  float errorPx(float error_model, double distance_model) const noexcept;

 private:
  /// The five planes that bound a picture. All pass through the eye: the four sides, and the plane
  /// perpendicular to the view direction, which excludes points behind the eye.
  class Pyramid {
   public:
    Pyramid(const View& view, double widening) noexcept;
    Visibility test(const ModelBox& box) const noexcept;
    const std::array<glm::dvec3, 5>& inward() const noexcept { return inward_; }

   private:
    glm::dvec3 eye_model_;
    std::array<glm::dvec3, 5> inward_;  // inward normals, not normalised
    std::array<glm::dvec3, 5> reach_;   // absolute values of the inward normals' components
  };

  glm::dvec3 eye_model_;
  double near_model_, focal_px_;
  Pyramid picture_, wider_;
};

}  // namespace lode::core
