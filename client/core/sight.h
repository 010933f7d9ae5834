#pragma once

#include <array>

#include <glm/glm.hpp>

#include "client/core/view.h"

namespace lode::core {

/// What screenErrorPx() and boxMayBeVisible() say, for many boxes of one view, whose angles are worked out
/// once.
class Sight {
 public:
  /// @param widening  of what a view that turns a little may see.
  Sight(const View& view, double widening) noexcept;

  bool maySee(const ModelBox& box) const noexcept { return picture_.mayMeet(box); }
  bool maySeeWhenTurned(const ModelBox& box) const noexcept {
    return picture_.mayMeet(box) ||
           wider_.mayMeet(box);  // a box around the eye may pass the narrower test alone
  }
  double distanceTo(const ModelBox& box) const noexcept { return distanceToBox(eye_model_, box); }
  float errorPx(float error_model, double distance_model) const noexcept;

 private:
  /// The pyramid of a picture, by inward normals of its sides and of the plane through the eye.
  class Pyramid {
   public:
    Pyramid(const View& view, double widening) noexcept;
    bool mayMeet(const ModelBox& box) const noexcept;

   private:
    glm::dvec3 eye_model_;
    std::array<glm::dvec3, 5> inward_;  // none needs unit length
  };

  glm::dvec3 eye_model_;
  double near_model_, focal_px_;
  Pyramid picture_, wider_;
};

}  // namespace lode::core
