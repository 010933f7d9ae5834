#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/lod/cut.h"
#include "client/core/view/view.h"

namespace lode::core {

/// A ray in the model frame.
struct Ray {
  glm::dvec3 origin_model{0}, direction{0, 0, -1};  ///< direction has unit length
};

/// Returns the ray from the eye through a point of the picture. @param place_px  distance in pixels from the
/// top left corner; y points down.
Ray rayThrough(const View& view, const glm::dvec2& place_px) noexcept;

/// Returns the distance along a ray from its origin to a box; 0 if the origin is inside, nothing on a miss.
std::optional<double> distanceAlong(const Ray& ray, const ModelBox& box) noexcept;

/// The nearest intersection of a ray with a cut.
struct Hit {
  const CutPart* part = nullptr;  ///< a part or fallback of the probed cut
  double distance_model = 0;
  glm::dvec3 position_model{0};
  uint32_t triangle = 0;  ///< index of the triangle in the part's mesh
  glm::dvec3 weights{0};  ///< barycentric weights of the triangle's corners
};

/// Intersects rays with the drawn triangles of a cut, for example to pick a point. Immutable.
class CutProbe {
 public:
  /// Computes the bounding box of every part from its mesh's cluster boxes, or from the vertices if the mesh
  /// has no cluster boxes.
  /// @param step  lattice step of the model.
  CutProbe(std::shared_ptr<const Cut> cut, double step);

  const std::shared_ptr<const Cut>& cut() const noexcept { return cut_; }
  double step() const noexcept { return step_; }
  /// Returns the nearest hit on either side of a triangle.
  /// @param shown  indices of the parts that are drawn, as shownParts() returns them.
  std::optional<Hit> cast(const Ray& ray, std::span<const uint32_t> shown) const;

 private:
  std::shared_ptr<const Cut> cut_;
  double step_;
  std::vector<LatticeBox> boxes_;  ///< bounding box of each part, indexed like partOf()
};

}  // namespace lode::core
