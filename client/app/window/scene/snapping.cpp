#include "client/app/window/scene/snapping.h"

#include <algorithm>
#include <cmath>

namespace lode::app {
namespace {

constexpr double kLeastSlant = 0.25;  ///< rays at a smaller sine to the surface count as this steep

}  // namespace

std::array<core::Ray, 3> snappingRays(const PickedPoint& point) noexcept {
  const glm::dvec3 reach = point.normal * (2 * uncertaintyOf(point));
  return {point.seen_along, core::Ray{point.position_model + reach, -point.normal},
          core::Ray{point.position_model - reach, point.normal}};
}

bool isSamePlace(const PickedPoint& point, const core::Ray& along, const PickedPoint& finer) noexcept {
  const double slant = std::max(kLeastSlant, std::abs(glm::dot(along.direction, point.normal)));
  return glm::distance(point.position_model, finer.position_model) <=
         (uncertaintyOf(point) + uncertaintyOf(finer)) / slant;
}

}  // namespace lode::app
