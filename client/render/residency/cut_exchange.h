#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "client/core/lod/cut.h"

namespace lode::render {

/// A part of the newer cut of one instance.
struct InstancePart {
  uint32_t instance = 0;
  uint32_t number = 0;  ///< argument of core::partOf()
};

/// Parts of the newer cuts whose meshes must be resident before any of them is drawn.
struct ExchangeStep {
  std::vector<InstancePart> parts;
  uint32_t instance = 0;          ///< instance of the region
  std::optional<NodeKey> region;  ///< region to switch then; none for the first step (fallbacks or all)
};

/// Plans the switch from older to newer cuts of a model's instances. Regions switch one by one, each when all
/// of its meshes are on the GPU: visible regions first, those with the largest error first, across instances.
/// In between a mixed cut covers the model: it has the newer or the older parts of each region and fallbacks
/// of either for regions left out, so it has no more holes than the two cuts. Uses no OpenGL.
class CutExchange {
 public:
  using Cuts = std::vector<std::shared_ptr<const core::Cut>>;  ///< by instance

  /// @param from  cuts of the same build, as many as `to`; empty: all of `to` is one step.
  CutExchange(Cuts from, Cuts to);

  std::span<const ExchangeStep> steps() const noexcept { return steps_; }
  /// Returns the cuts to draw after the first `steps` steps: per instance `from` if none of its steps is
  /// done, `to` if all are, else a mixed cut. Reuses the mixed cut of an instance that made no progress.
  Cuts after(size_t steps);

 private:
  struct Mixture {
    size_t steps = 0;  ///< steps of the instance done so far
    std::shared_ptr<const core::Cut> cut;
  };

  void planRegions();
  std::shared_ptr<const core::Cut> mixtureAt(uint32_t instance, std::vector<NodeKey> regions_left) const;

  Cuts from_, to_;
  std::vector<ExchangeStep> steps_;
  std::vector<Mixture> mixtures_;  ///< by instance, the latest
};

}  // namespace lode::render
