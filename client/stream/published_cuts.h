#pragma once

#include <memory>
#include <vector>

#include "client/core/lod/cut.h"

namespace lode::stream {

/// Keeps every published cut until no one else holds it, so that the refinement thread frees its meshes, not
/// the render thread during a frame. Holds the cuts that others hold, and the last one. Not thread safe.
class PublishedCuts {
 public:
  void add(const std::shared_ptr<const core::Cut>& cut,
           const std::shared_ptr<const core::ViewCuts>& view_cuts);
  /// Frees the cuts that no one else holds.
  void releaseStorage();

 private:
  std::vector<std::shared_ptr<const core::Cut>> cuts_;
  std::vector<std::shared_ptr<const core::ViewCuts>> view_cuts_;
};

}  // namespace lode::stream
