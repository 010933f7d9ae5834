#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/core/view/view.h"
#include "client/render/residency/mesh_residency.h"

namespace lode::render {

/// A part of a cut (core::CutPart) that may be visible.
struct SeenPart {
  const DrawItem* item = nullptr;
  uint32_t state = 0;  ///< index of the part's DrawState in the caller's array
  bool fades = false;
};

/// A cluster of a part that may be visible.
struct SeenCluster {
  SeenPart part;
  uint32_t number = 0;  ///< index of the cluster within the part's mesh

  uint32_t firstTriangle() const noexcept { return number * kClusterTriangles; }
  uint32_t triangles() const noexcept;
  const LatticeBox& box() const noexcept { return part.item->clusters->boxes[number]; }
  /// Returns a reference to a flag: true if other geometry hid the cluster when the instance was last drawn.
  std::vector<bool>::reference hidden(size_t instance) const;
};

/// Returns true if a part's box may intersect the view frustum.
bool isInPicture(const SeenPart& part, const core::ViewFrustum& frustum, double lattice_step);

/// Adds to `seen` each cluster of a part if the cluster's box may intersect the view frustum.
/// @return number of clusters added.
size_t addSeenClusters(const SeenPart& part, const core::ViewFrustum& frustum, double lattice_step,
                       std::vector<SeenCluster>& seen);

/// A draw command in the layout of glMultiDrawElementsIndirect().
struct DrawCommand {
  uint32_t count, instance_count, first_index;
  int32_t base_vertex;
  uint32_t base_instance;
};

/// Draw commands of one shader program, grouped by GPU page (see GpuPages).
struct DrawList {
  void clear(size_t pages);
  /// Adds a cluster. Extends the page's last command if the cluster directly follows that command's triangles
  /// in memory and has the same draw state.
  void add(const SeenCluster& cluster);
  bool empty() const noexcept;

  std::vector<std::vector<DrawCommand>> by_page;
  size_t first = 0;  ///< index of the list's first command in the command buffer
};

}  // namespace lode::render
