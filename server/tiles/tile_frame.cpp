#include "server/tiles/tile_frame.h"

#include <cmath>

namespace lode::tiles {
namespace {

/// WGS 84: equatorial radius in metres and flattening.
constexpr double kRadius = 6378137, kFlattening = 1 / 298.257223563;

/// Returns the rotation that maps right, the direction away from the viewer, and up to x, y and z. Right is x
/// if possible, as in the client's first view.
glm::dmat3 uprightFrom(const glm::dvec3& up) {
  const glm::dvec3 right = std::abs(up.x) > 0.5 ? glm::dvec3(0, 0, -up.x) : glm::dvec3(1, 0, 0);
  return glm::transpose(glm::dmat3(right, glm::cross(up, right), up));
}

/// East, north and up at a place, as columns, and the place itself.
struct LocalFrame {
  glm::dmat3 axes;
  glm::dvec3 place;
};

LocalFrame localFrame(const GeoPosition& at) {
  const double longitude = glm::radians(at.longitude_deg), latitude = glm::radians(at.latitude_deg);
  const glm::dvec3 east(-std::sin(longitude), std::cos(longitude), 0);
  const glm::dvec3 up(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                      std::sin(latitude));
  constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);
  const double normal = kRadius / std::sqrt(1 - kEccentricity2 * up.z * up.z);
  const glm::dvec3 foot = normal * up * glm::dvec3(1, 1, 1 - kEccentricity2);
  return {{east, glm::cross(up, east), up}, foot + at.height_m * up};
}

glm::dmat4 joined(const glm::dmat3& rotation, const glm::dvec3& translation) {
  glm::dmat4 matrix(rotation);
  matrix[3] = glm::dvec4(translation, 1);
  return matrix + glm::dmat4(0.0);  // turns -0 to 0
}

}  // namespace

ModelBox toModelBox(const LatticeBox& box, double step) {
  if (box.empty()) return {glm::dvec3(0), glm::dvec3(step / 2)};
  const glm::dvec3 low = glm::dvec3(box.min) * step, high = glm::dvec3(box.max) * step;
  return {(low + high) / 2.0, glm::max((high - low) / 2.0, step / 2)};
}

glm::dmat4 rootTransform(const ModelSummary& model, const glm::dvec3& up,
                         const std::optional<GeoPosition>& at) {
  const glm::dmat3 upright = uprightFrom(up);
  if (!at) return joined(upright, upright * model.lattice.origin);
  const LocalFrame frame = localFrame(*at);
  const glm::dmat3 rotation = frame.axes * upright;
  const ModelBox box = toModelBox(model.box, model.lattice.step);
  const glm::dvec3 foot = box.centre - up * glm::dot(box.half, glm::abs(up));
  return joined(rotation, frame.place - rotation * foot);
}

}  // namespace lode::tiles
