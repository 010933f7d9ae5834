#pragma once

#include <memory>
#include <vector>

#include "client/core/lod/cut.h"

namespace lode::stream {

/// The cuts that a stream has given out, each kept until nobody else has it: its meshes are freed where it
/// was published, in the time of the thread that refines, and not in a frame of the one that draws. There are
/// as many as others hold, and the last. Not thread safe.
class PublishedCuts {
 public:
  void add(const std::shared_ptr<const core::Cut>& cut,
           const std::shared_ptr<const core::ViewCuts>& view_cuts);
  /// Frees what nobody else has any more.
  void releaseStorage();

 private:
  std::vector<std::shared_ptr<const core::Cut>> cuts_;
  std::vector<std::shared_ptr<const core::ViewCuts>> view_cuts_;
};

}  // namespace lode::stream
