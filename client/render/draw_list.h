#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/render/culling/cluster_culling.h"

namespace lode::render {

/// As glMultiDrawElementsIndirect reads it.
struct DrawCommand {
  uint32_t count, instance_count, first_index;
  int32_t base_vertex;
  uint32_t base_instance;
};

/// Clusters that are drawn with one program, by the pages that their meshes are in.
struct DrawList {
  void clear(size_t pages);
  /// What follows on the last one in memory goes with it.
  void add(const SeenCluster& cluster);
  bool empty() const noexcept;

  std::vector<std::vector<DrawCommand>> by_page;
  size_t first = 0;  ///< in the buffer of commands
};

}  // namespace lode::render
