#pragma once

#include <memory>
#include <span>
#include <vector>

#include "client/core/lod/cut.h"
#include "client/core/lod/request.h"

namespace lode::core {

/// The cuts of one model for all of its views, which share meshes. Immutable, as cuts are.
struct ViewCuts {
  std::vector<std::shared_ptr<const Cut>> cuts;  ///< by view
  /// All that they are drawn from: of one view its cut; of several, their parts and fallbacks as parts, each
  /// mesh once, with the textures, their triangles added up, and the largest error.
  std::shared_ptr<const Cut> all;
};

/// @param cuts  of one build and threshold, one at least.
std::shared_ptr<Cut> gatherMeshes(std::span<const std::shared_ptr<const Cut>> cuts);

/// The requests of several views, each blob use once: with the best class and the largest priority that one
/// of them has for it. Best first.
std::vector<Request> mergeRequests(std::span<const std::vector<Request>> requests);

}  // namespace lode::core
