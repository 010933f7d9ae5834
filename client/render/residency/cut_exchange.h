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
  uint32_t number = 0;  ///< number of the part, see core::partOf()
};

/// Parts of the newer cuts whose meshes must be resident before any of them is drawn.
struct ExchangeStep {
  std::vector<InstancePart> parts;
  uint32_t instance = 0;          ///< instance whose region switches
  std::optional<NodeKey> region;  ///< region to switch then; none for the first step (fallbacks or all)
};

/// Plans the switch from older to newer cuts of a model's instances. Regions switch one by one, each as
/// soon as all of its meshes are on the GPU: visible regions before others, and regions with larger errors
/// before those with smaller errors, across instances. In between, a mixed cut covers the model. In each
/// region the mixed cut has either the newer or the older parts, and for regions left out it has fallbacks of
/// either cut, so each of its holes is also a hole of one of the two cuts. Uses no OpenGL.
class CutExchange {
 public:
  using Cuts = std::vector<std::shared_ptr<const core::Cut>>;  ///< one cut per instance

  /// @param from  cuts of the same build, as many as in `to`. If empty, one step switches to all of `to`.
  CutExchange(Cuts from, Cuts to);

  std::span<const ExchangeStep> steps() const noexcept { return steps_; }
  /// Returns the cuts to draw after the first `steps` steps: for an instance `from` if none of its steps is
  /// done, `to` if all of its steps are done, else a mixed cut. Reuses the mixed cut of an instance that made
  /// no progress.
  Cuts after(size_t steps);

 private:
  struct Mixture {
    size_t steps = 0;  ///< number of the instance's steps done so far
    std::shared_ptr<const core::Cut> cut;
  };

  void planRegions();
  std::shared_ptr<const core::Cut> mixtureAt(uint32_t instance, std::vector<NodeKey> regions_left) const;

  Cuts from_, to_;
  std::vector<ExchangeStep> steps_;
  std::vector<Mixture> mixtures_;  ///< latest mixture of each instance
};

}  // namespace lode::render
