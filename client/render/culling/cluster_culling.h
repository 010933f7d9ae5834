#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/core/view/view.h"
#include "client/render/residency/mesh_residency.h"

namespace lode::render {

/// A part that may be visible.
struct SeenPart {
  const DrawItem* item = nullptr;
  uint32_t state = 0;  ///< index of the part's draw state in the caller's array
  bool fades = false;
};

/// A cluster of a part that may be visible.
struct SeenCluster {
  SeenPart part;
  uint32_t number = 0;  ///< index in part.item->clusters

  uint32_t firstTriangle() const noexcept { return number * kClusterTriangles; }
  uint32_t triangles() const noexcept;
  const LatticeBox& box() const noexcept { return part.item->clusters->boxes[number]; }
  /// Returns the flag that is true if other geometry hid the cluster in the instance's last frame.
  std::vector<bool>::reference hidden(size_t instance) const;
};

/// Returns true if a part's box may be in the view frustum.
bool isInPicture(const SeenPart& part, const core::ViewFrustum& frustum, double lattice_step);

/// Adds the clusters of a part whose boxes may be in the view frustum. @return number of clusters added.
size_t addSeenClusters(const SeenPart& part, const core::ViewFrustum& frustum, double lattice_step,
                       std::vector<SeenCluster>& seen);

/// A draw command in the layout of glMultiDrawElementsIndirect().
struct DrawCommand {
  uint32_t count, instance_count, first_index;
  int32_t base_vertex;
  uint32_t base_instance;
};

/// Draw commands of one shader program, grouped by page.
struct DrawList {
  void clear(size_t pages);
  /// Adds a cluster. If the cluster directly follows the last command's triangles in memory, extends this
  /// command.
  void add(const SeenCluster& cluster);
  bool empty() const noexcept;

  std::vector<std::vector<DrawCommand>> by_page;
  size_t first = 0;  ///< index of the list's first command in the command buffer
};

}  // namespace lode::render
