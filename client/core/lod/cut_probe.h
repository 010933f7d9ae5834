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

/// Half a line in the model frame.
struct Ray {
  glm::dvec3 origin_model{0}, direction{0, 0, -1};  ///< the latter of unit length
};

/// From the eye through a place of the picture. @param place_px  from its top left corner, y down.
Ray rayThrough(const View& view, const glm::dvec2& place_px) noexcept;

/// How far along a ray a box begins, 0 inside; nothing if the ray passes it by.
std::optional<double> distanceAlong(const Ray& ray, const ModelBox& box) noexcept;

/// Where a ray meets a cut first.
struct Hit {
  const CutPart* part = nullptr;  ///< of the probed cut, or one of its fallbacks
  double distance_model = 0;
  glm::dvec3 position_model{0};
  uint32_t triangle = 0;  ///< of the part's mesh,
  glm::dvec3 weights{0};  ///< and of its corners at the point
};

/// Looks for what lies under a place of the picture, on the triangles that are drawn. Immutable.
class CutProbe {
 public:
  /// Reads the boxes of clusters; of meshes without, every vertex once. @param step  of the model's lattice.
  CutProbe(std::shared_ptr<const Cut> cut, double step);

  const std::shared_ptr<const Cut>& cut() const noexcept { return cut_; }
  double step() const noexcept { return step_; }
  /// Looks at the triangles of parts whose box the ray meets, from both sides.
  /// @param shown  the parts that are drawn: see shownParts().
  std::optional<Hit> cast(const Ray& ray, std::span<const uint32_t> shown) const;

 private:
  std::shared_ptr<const Cut> cut_;
  double step_;
  std::vector<LatticeBox> boxes_;  ///< by the numbers of partOf()
};

}  // namespace lode::core
