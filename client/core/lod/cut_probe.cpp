#include "client/core/lod/cut_probe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "client/core/lod/cut.h"

namespace lode::core {
namespace {

struct TriangleHit {
  double distance;
  glm::dvec3 weights;  ///< barycentric weight of each corner
};

/// Source: Moeller & Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997.
std::optional<TriangleHit> intersect(const std::array<glm::dvec3, 3>& corners, const Ray& ray) {
  const glm::dvec3 a = corners[1] - corners[0], b = corners[2] - corners[0];
  const glm::dvec3 across = glm::cross(ray.direction, b);
  const double determinant = glm::dot(a, across);
  if (determinant == 0) return std::nullopt;
  const glm::dvec3 offset = ray.origin_model - corners[0];
  const double u = glm::dot(offset, across) / determinant;
  if (u < 0 || u > 1) return std::nullopt;
  const glm::dvec3 up = glm::cross(offset, a);
  const double v = glm::dot(ray.direction, up) / determinant;
  if (v < 0 || u + v > 1) return std::nullopt;
  const double distance = glm::dot(b, up) / determinant;
  if (!(distance > 0)) return std::nullopt;
  return TriangleHit{distance, {1 - u - v, u, v}};
}

}  // namespace

Ray rayThrough(const View& view, const glm::dvec2& place_px) noexcept {
  const glm::dvec3 right = glm::cross(view.forward, view.up);
  const double slope_per_px = 2 * std::tan(view.fov_y_rad / 2) / std::max(1u, view.height_px);
  const glm::dvec2 middle_px(view.width_px / 2.0, view.height_px / 2.0);
  const glm::dvec2 slope = (place_px - middle_px) * slope_per_px;
  return {view.eye_model, glm::normalize(view.forward + slope.x * right - slope.y * view.up)};
}

std::optional<double> distanceAlong(const Ray& ray, const ModelBox& box) noexcept {
  double enter = 0, leave = std::numeric_limits<double>::max();
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.min[axis] - ray.origin_model[axis], high = box.max[axis] - ray.origin_model[axis];
    if (ray.direction[axis] == 0) {
      if (low > 0 || high < 0) return std::nullopt;
      continue;
    }
    const double a = low / ray.direction[axis], b = high / ray.direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? std::optional(enter) : std::nullopt;
}

CutProbe::CutProbe(std::shared_ptr<const Cut> cut, double step) : cut_(std::move(cut)), step_(step) {
  boxes_.resize(partCount(*cut_));
  for (size_t number = 0; number < boxes_.size(); ++number) {
    const CutPart& part = partOf(*cut_, number);
    if (!part.mesh) continue;
    for (const LatticeBox& box : part.mesh->cluster_boxes) boxes_[number].add(box);
    if (!part.mesh->cluster_boxes.empty()) continue;
    for (const PositionCode code : part.mesh->positions) boxes_[number].add(unpackPosition(code));
  }
}

std::optional<Hit> CutProbe::cast(const Ray& ray, std::span<const uint32_t> shown) const {
  std::optional<Hit> nearest;
  double limit = std::numeric_limits<double>::max();
  for (const uint32_t number : shown) {
    if (boxes_[number].empty()) continue;
    const std::optional<double> begin = distanceAlong(ray, toModelBox(boxes_[number], step_));
    if (!begin || *begin > limit) continue;
    const CutPart& part = partOf(*cut_, number);
    const Mesh& mesh = *part.mesh;
    for (size_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
      std::array<glm::dvec3, 3> corners;
      for (int k = 0; k < 3; ++k)
        corners[k] = glm::dvec3(unpackPosition(mesh.positions[mesh.triangles[triangle][k]])) * step_;
      const std::optional<TriangleHit> met = intersect(corners, ray);
      if (!met || met->distance >= limit) continue;
      limit = met->distance;
      nearest = Hit{&part, limit, ray.origin_model + limit * ray.direction, static_cast<uint32_t>(triangle),
                    met->weights};
    }
  }
  return nearest;
}

}  // namespace lode::core
