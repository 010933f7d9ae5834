#include "client/core/lod/part_error.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "common/nearest_point.h"

namespace lode::core {
namespace {

/// partErrorPx() searches the mesh if the eye is nearer to the box than this fraction of the box's diagonal.
/// Farther away, the distance to the box is almost the distance to the mesh.
constexpr double kNearShare = 0.125;

ModelBox widened(ModelBox box, double by) {
  box.min -= by;
  box.max += by;
  return box;
}

/// A triangle, clipped to the picture.
class ClippedTriangle {
 public:
  explicit ClippedTriangle(const TriangleCorners& corners) : corners_{corners[0], corners[1], corners[2]} {}

  /// Keeps the region whose signed distance from a plane through the eye is at least `height`.
  /// @param inward  unit normal of the plane.
  void clip(glm::dvec3 eye, glm::dvec3 inward, double height) {
    const size_t count = std::exchange(count_, 0);
    const std::array<glm::dvec3, kMost> before = corners_;
    for (size_t i = 0; i < count; ++i) {
      const glm::dvec3 a = before[i], b = before[(i + 1) % count];
      const double of_a = glm::dot(a - eye, inward) - height, of_b = glm::dot(b - eye, inward) - height;
      if (of_a >= 0) corners_[count_++] = a;
      if ((of_a >= 0) != (of_b >= 0)) corners_[count_++] = glm::mix(a, b, of_a / (of_a - of_b));
    }
  }

  /// Returns the distance to a point; infinity if nothing is left.
  double distance(glm::dvec3 point) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (size_t i = 1; i + 1 < count_; ++i)
      nearest = std::min(
          nearest,
          glm::distance(point, nearestPointOfTriangle(point, {corners_[0], corners_[i], corners_[i + 1]})));
    return nearest;
  }

 private:
  static constexpr size_t kMost = 8;  ///< each of five planes adds at most one corner
  std::array<glm::dvec3, kMost> corners_;
  size_t count_ = 3;
};

/// Searches a mesh for the visible triangle that is nearest to the eye. The margin widens the picture, and is
/// subtracted from the distance.
class MeshInPicture {
 public:
  MeshInPicture(const Mesh& mesh, double step, double margin_model, const ViewFrustum& frustum)
      : mesh_(mesh),
        step_(step),
        margin_model_(margin_model),
        frustum_(frustum),
        inward_(frustum.inwardNormals()) {}

  /// Returns the distance from the eye to the nearest visible triangle, minus the margin; infinity if no
  /// triangle is in the picture.
  double nearest() const {
    std::vector<Cluster> clusters;
    clusters.reserve(mesh_.cluster_boxes.size());
    for (uint32_t i = 0; i < mesh_.cluster_boxes.size(); ++i)
      clusters.push_back({frustum_.distanceTo(boxOf(i)), i});
    std::make_heap(clusters.begin(), clusters.end(), isFarther);
    double nearest = std::numeric_limits<double>::infinity();
    while (!clusters.empty() && clusters.front().distance < nearest) {
      const uint32_t cluster = clusters.front().number;
      std::pop_heap(clusters.begin(), clusters.end(), isFarther);
      clusters.pop_back();
      if (frustum_.test(boxOf(cluster)) != Visibility::kOutside)
        nearest = std::min(nearest, nearestIn(cluster, nearest));
    }
    return nearest;
  }

 private:
  struct Cluster {
    double distance;
    uint32_t number;
  };
  static bool isFarther(const Cluster& a, const Cluster& b) noexcept { return a.distance > b.distance; }

  ModelBox boxOf(uint32_t cluster) const {
    return widened(toModelBox(mesh_.cluster_boxes[cluster], step_), margin_model_);
  }

  double nearestIn(uint32_t cluster, double bound) const {
    const size_t first = size_t{cluster} * kClusterTriangles;
    const size_t count = std::min<size_t>(kClusterTriangles, mesh_.triangles.size() - first);
    for (const glm::u32vec3& t : std::span(mesh_.triangles).subspan(first, count)) {
      const TriangleCorners corners{cornerOf(t.x), cornerOf(t.y), cornerOf(t.z)};
      const glm::dvec3 eye = frustum_.eyeModel();
      if (glm::distance(eye, nearestPointOfTriangle(eye, corners)) - margin_model_ >= bound) continue;
      ClippedTriangle visible(corners);
      for (const glm::dvec3& inward : inward_) visible.clip(eye, inward, -margin_model_);
      bound = std::clamp(visible.distance(eye) - margin_model_, 0.0, bound);
    }
    return bound;
  }

  glm::dvec3 cornerOf(uint32_t vertex) const {
    return glm::dvec3(unpackPosition(mesh_.positions[vertex])) * step_;
  }

  const Mesh& mesh_;
  const double step_, margin_model_;
  const ViewFrustum& frustum_;
  const std::array<glm::dvec3, 5> inward_;
};

}  // namespace

float partErrorPx(const CutPart& part, double lattice_step, const ViewFrustum& frustum) {
  if (frustum.test(part.box) == Visibility::kOutside) return 0;
  double distance_model = frustum.distanceTo(part.box);
  const bool is_near = distance_model < kNearShare * glm::distance(part.box.min, part.box.max);
  if (is_near && lattice_step > 0 && part.mesh && !part.mesh->cluster_boxes.empty()) {
    const double nearest =
        MeshInPicture(*part.mesh, lattice_step, static_cast<double>(part.error_model), frustum).nearest();
    distance_model = std::max(distance_model, nearest);
  }
  return frustum.errorPx(part.off_model, distance_model);
}

}  // namespace lode::core
