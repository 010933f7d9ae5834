#include "common/up_axis.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/lattice.h"

namespace lode {
namespace {

/// A mesh is terrain if the sum of its area vectors along an axis exceeds this fraction of its area.
constexpr double kOpenPart = 0.2;
constexpr double kOpenFactor = 1.5;  ///< required ratio of this sum to the sum along the other axis
/// The z axis is up if Areas::standing is larger for z than for y by this fraction of the mesh's area.
constexpr double kFootPart = 0.03;
/// Height of the zone at either end of an axis, relative to the mesh's extent.
constexpr double kFootHeight = 0.03;
/// A triangle is flat (perpendicular to an axis) if the angle between its normal and the axis has at least
/// this cosine.
constexpr double kDownwards = 0.7;

/// Areas of a mesh's triangles, in total and by axis.
struct Areas {
  double all = 0;
  glm::dvec3 facing{0};  ///< signed sum of the triangles' area vectors
  /// Area of the flat triangles at the lower end of each axis, minus the same at the upper end.
  glm::dvec3 standing{0};
};

LatticeBox boxOf(const Mesh& mesh) {
  LatticeBox box;
  for (const PositionCode code : mesh.positions) box.add(unpackPosition(code));
  return box;
}

Areas measure(const Mesh& mesh) {
  const LatticeBox box = boxOf(mesh);
  const glm::dvec3 low(box.min), size = glm::max(glm::dvec3(box.max) - low, 1.0);
  Areas areas;
  for (const glm::u32vec3& triangle : mesh.triangles) {
    std::array<glm::dvec3, 3> corners;
    for (int i = 0; i < 3; ++i) corners[i] = glm::dvec3(unpackPosition(mesh.positions[triangle[i]]));
    const glm::dvec3 area = glm::cross(corners[1] - corners[0], corners[2] - corners[0]) / 2.0;
    const double length = glm::length(area);
    const glm::dvec3 height = ((corners[0] + corners[1] + corners[2]) / 3.0 - low) / size;
    areas.all += length;
    areas.facing += area;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(area[axis]) < kDownwards * length) continue;
      if (height[axis] < kFootHeight) areas.standing[axis] += length;
      if (height[axis] > 1 - kFootHeight) areas.standing[axis] -= length;
    }
  }
  return areas;
}

}  // namespace

std::optional<glm::dvec3> parseAxis(std::string_view text) noexcept {
  const bool is_negative = text.starts_with('-');
  if (is_negative) text.remove_prefix(1);
  if (text.size() != 1 || text[0] < 'x' || text[0] > 'z') return std::nullopt;
  glm::dvec3 axis(0);
  axis[text[0] - 'x'] = is_negative ? -1 : 1;
  return axis;
}

std::string nameOfAxis(const glm::dvec3& axis) {
  for (const char* name : {"x", "y", "z", "-x", "-y"})
    if (parseAxis(name) == axis) return name;
  return "-z";
}

glm::dvec3 guessUp(const Mesh& coarse) {
  constexpr glm::dvec3 kY(0, 1, 0), kZ(0, 0, 1);
  const Areas areas = measure(coarse);
  const double open_y = std::abs(areas.facing.y), open_z = std::abs(areas.facing.z);
  if (std::max(open_y, open_z) > kOpenPart * areas.all) {
    if (open_y > kOpenFactor * open_z) return kY;
    if (open_z > kOpenFactor * open_y) return kZ;
  }
  return areas.standing.z > areas.standing.y + kFootPart * areas.all ? kZ : kY;
}

}  // namespace lode
