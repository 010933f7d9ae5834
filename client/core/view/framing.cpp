#include "client/core/view/framing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/up_axis.h"

namespace lode::core {
namespace {

constexpr double kMargin = 1.08;  ///< size of the picture relative to the projected model
constexpr double kTurnDeg = 35;   ///< rotation of the camera away from the broader side's normal
constexpr double kLeastTiltDeg = 28, kLargestTiltDeg = 40;

/// Axes of a model: right, up, and towards a viewer in front of the model.
struct Stand {
  glm::dvec3 right, up, front;
};

Stand standOf(const glm::dvec3& up) {
  // Right is x if possible, so that the front is +z if y is up and -y if z is up.
  const glm::dvec3 right = std::abs(up.x) > 0.5 ? glm::dvec3(0, 0, -up.x) : glm::dvec3(1, 0, 0);
  return {right, up, glm::cross(right, up)};
}

std::vector<glm::dvec3> pointsOf(const ModelSummary& model, const Mesh* mesh) {
  std::vector<glm::dvec3> points;
  if (mesh != nullptr && !mesh->positions.empty()) {
    points.reserve(mesh->positions.size());
    for (const PositionCode code : mesh->positions)
      points.push_back(model.lattice.toWorld(unpackPosition(code)));
    return points;
  }
  if (model.box.empty()) return {model.lattice.origin};
  const glm::dvec3 low = model.lattice.toWorld(model.box.min), high = model.lattice.toWorld(model.box.max);
  for (int corner = 0; corner < 8; ++corner)
    points.emplace_back(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                        corner & 4 ? high.z : low.z);
  return points;
}

/// Smallest and largest coordinate of points along a direction.
struct Reach {
  double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
  void add(double place) {
    low = std::min(low, place);
    high = std::max(high, place);
  }
  double size() const { return high - low; }
  double middle() const { return (low + high) / 2; }
};

Reach reachAlong(const std::vector<glm::dvec3>& points, const glm::dvec3& direction) {
  Reach reach;
  for (const glm::dvec3& point : points) reach.add(glm::dot(point, direction));
  return reach;
}

glm::dvec3 directionToEye(const std::vector<glm::dvec3>& points, const Stand& stand) {
  const double width = reachAlong(points, stand.right).size(), depth = reachAlong(points, stand.front).size();
  const double height = reachAlong(points, stand.up).size();
  const double turn = glm::radians(width >= depth ? kTurnDeg : 90 - kTurnDeg);
  const double tallness = std::min(1.0, height / std::max({width, depth, 1e-300}));
  const double tilt = glm::radians(glm::mix(kLargestTiltDeg, kLeastTiltDeg, tallness));
  return std::cos(tilt) * (std::sin(turn) * stand.right + std::cos(turn) * stand.front) +
         std::sin(tilt) * stand.up;
}

glm::dvec3 directionTo(Side side, const Stand& stand) {
  switch (side) {
    case Side::kFront:
      return stand.front;
    case Side::kBack:
      return -stand.front;
    case Side::kLeft:
      return -stand.right;
    case Side::kRight:
      return stand.right;
    case Side::kTop:
      return stand.up;
    case Side::kBottom:
      break;
  }
  return -stand.up;
}

/// The nearest eye position from which all points lie between two opposite sides of the picture. `across` is
/// the eye's coordinate to the right or upwards, `out` its coordinate towards the viewer.
struct Fit {
  double across, out;
};

/// The shape to frame: surface points, their largest error, and the corners of the bounding box.
struct Shape {
  std::vector<glm::dvec3> points;
  double error;
  std::vector<glm::dvec3> box;

  Reach along(const glm::dvec3& direction) const {
    const Reach near = reachAlong(points, direction), most = reachAlong(box, direction);
    const double more = error * glm::length(direction);
    return {std::max(near.low - more, most.low), std::min(near.high + more, most.high)};
  }
};

/// @param slope  half of the picture's width or height at distance 1.
Fit fit(const Shape& shape, const glm::dvec3& side, const glm::dvec3& to_eye, double slope) {
  const Reach reach{shape.along(side - slope * to_eye).low, shape.along(side + slope * to_eye).high};
  return {reach.middle(), reach.size() / (2 * slope)};
}

/// Returns the eye's coordinate along `side` at which the points appear centred. @param out  the eye's
/// coordinate along `to_eye`. @param across  first guess.
double centred(const std::vector<glm::dvec3>& points, const glm::dvec3& side, const glm::dvec3& to_eye,
               double across, double out) {
  constexpr int kTurns = 8;  // number of iterations; each improves the result
  const double middle = out - reachAlong(points, to_eye).middle();
  for (int turn = 0; turn < kTurns; ++turn) {
    Reach slopes;
    for (const glm::dvec3& point : points)
      slopes.add((glm::dot(point, side) - across) / (out - glm::dot(point, to_eye)));
    across += slopes.middle() * middle;
  }
  return across;
}

}  // namespace

glm::dvec3 upOf(const Framing& framing) {
  if (framing.up) return *framing.up;
  return framing.coarse ? guessUp(*framing.coarse) : glm::dvec3(0, 1, 0);
}

CameraPath framingCamera(const ModelSummary& model, const Framing& framing) {
  const Mesh* const mesh = framing.coarse.get();
  const glm::dvec3 up = upOf(framing);
  Shape shape{pointsOf(model, mesh), mesh != nullptr ? model.max_error_model : 0, pointsOf(model, nullptr)};
  const glm::dvec3 centre = shape.box.front();  // coordinates relative to this point keep their precision
  for (auto* points : {&shape.points, &shape.box})
    for (glm::dvec3& point : *points) point -= centre;

  CameraPath path;
  path.fov_y_deg = framing.fov_y_deg;
  const Stand stand = standOf(up);
  const glm::dvec3 to_eye =
      framing.side ? directionTo(*framing.side, stand) : directionToEye(shape.points, stand);
  const bool is_along_up = framing.side == Side::kTop || framing.side == Side::kBottom;
  const glm::dvec3 right = is_along_up ? stand.right : glm::normalize(glm::cross(up, to_eye));
  const glm::dvec3 above = glm::cross(to_eye, right);
  const double slope = std::tan(glm::radians(path.fov_y_deg) / 2) / kMargin;
  // Slope of the direction through the middle of the uncovered part of the picture. `beside` is `right`,
  // sheared so that this direction has coordinate 0.
  const double middle_slope = framing.covered * kMargin * slope * framing.aspect;
  const glm::dvec3 beside = right + middle_slope * to_eye;
  const Fit horizontal = fit(shape, beside, to_eye, slope * framing.aspect * (1 - framing.covered));
  const Fit vertical = fit(shape, above, to_eye, slope);
  const Reach depth = reachAlong(shape.points, to_eye);
  double out = std::max(horizontal.out, vertical.out);
  if (!(out > depth.high)) out = depth.high + 1;  // the shape is a point, or a line that points at the eye
  const double across = centred(shape.points, beside, to_eye, horizontal.across, out) - middle_slope * out;
  const glm::dvec3 aside =
      centre + across * right + centred(shape.points, above, to_eye, vertical.across, out) * above;
  path.keys.push_back({0, aside + out * to_eye, aside + depth.middle() * to_eye, is_along_up ? above : up});
  return path;
}

}  // namespace lode::core
