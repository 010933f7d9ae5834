#pragma once

#include <memory>
#include <vector>

#include "client/core/view.h"
#include "common/mesh.h"
#include "common/node_key.h"

namespace lode::core {

/// One drawn part of the model. The mesh is shared with the cache and never changes.
struct CutPart {
  NodeKey node;
  uint32_t rung = 0;
  bool visible = true;  ///< false: outside the view, held for completeness
  float error_px = 0;   ///< projected error at refinement
  std::shared_ptr<const Mesh> mesh;
};

/// What covers the model exactly once (design: cut), in key order; published by the refiner, immutable, read
/// by the renderer on another thread. Parts without triangles are left out.
struct Cut {
  View view;  ///< for which it was refined
  std::vector<CutPart> parts;
  uint64_t triangles = 0;
  float max_error_px = 0;  ///< of the visible parts
  bool converged = false;  ///< nothing visible is above the threshold, but leaves at their original triangles
};

}  // namespace lode::core
