#pragma once

#include <memory>
#include <vector>

#include "client/core/lod/cut.h"

namespace lode::stream {

/// Keeps a reference to every published cut until all other references are gone. The refinement thread then
/// frees the cut's meshes. If the render thread dropped the last reference, it would free them and delay a
/// frame. Not thread safe.
class PublishedCuts {
 public:
  void add(const std::shared_ptr<const core::Cut>& cut,
           const std::shared_ptr<const core::ViewCuts>& view_cuts);
  /// Frees the cuts to which no other references exist.
  void releaseStorage();

 private:
  std::vector<std::shared_ptr<const core::Cut>> cuts_;
  std::vector<std::shared_ptr<const core::ViewCuts>> view_cuts_;
};

}  // namespace lode::stream
