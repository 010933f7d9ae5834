#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

#include "client/core/view/view.h"

namespace lode::core {

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
