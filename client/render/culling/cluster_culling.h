#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/core/view/view.h"
#include "client/render/residency/mesh_residency.h"

namespace lode::render {

/// A part that may be in the picture.
struct SeenPart {
  const DrawItem* item = nullptr;
  uint32_t state = 0;  ///< what else a draw needs, by the caller's numbers
  bool fades = false;
};

/// Some triangles of a part, near one another, that may be in the picture.
struct SeenCluster {
  SeenPart part;
  uint32_t number = 0;  ///< in part.item->clusters

  uint32_t firstTriangle() const noexcept { return number * kClusterTriangles; }
  uint32_t triangles() const noexcept;
  const LatticeBox& box() const noexcept { return part.item->clusters->boxes[number]; }
  /// By others, in the last frame. @param place  where the model stands.
  std::vector<bool>::reference hidden(size_t instance) const;
};

bool isInPicture(const SeenPart& part, const core::ViewFrustum& frustum, double lattice_step);

/// Adds what a camera may see of a part: all but clusters that are not in its picture.
/// @return how many were added.
size_t addSeenClusters(const SeenPart& part, const core::ViewFrustum& frustum, double lattice_step,
                       std::vector<SeenCluster>& seen);

}  // namespace lode::render
