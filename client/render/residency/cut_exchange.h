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

/// A step of the switch from older to newer cuts: parts of the newer cuts that appear together, once all
/// their meshes are resident.
struct ExchangeStep {
  std::vector<InstancePart> parts;
  uint32_t instance = 0;  ///< instance whose region switches
  /// Region that switches; empty for the first step, which has the fallbacks of the newer cuts, or all parts
  /// if there are no older cuts.
  std::optional<NodeKey> region;
};

/// Plans the switch from older to newer cuts of a model's instances. Regions switch one by one, each as soon
/// as all its meshes are on the GPU. Visible regions come first, and regions with larger errors before
/// regions with smaller errors, whatever their instance. Meanwhile a mixed cut covers the model. In each
/// region the mixed cut has either the newer or the older parts. The mixed cut has the fallbacks of both
/// cuts, so that it shows a hole (a visible place that nothing covers) only where one of the two cuts would.
/// Uses no OpenGL.
class CutExchange {
 public:
  using Cuts = std::vector<std::shared_ptr<const core::Cut>>;  ///< one cut per instance

  /// @param from  older cuts of the same build, as many as in `to`. If the list is empty, one step switches
  /// to all of `to`.
  CutExchange(Cuts from, Cuts to);

  std::span<const ExchangeStep> steps() const noexcept { return steps_; }
  /// Returns the cuts to draw after the first `steps` steps. An instance draws its `from` cut if none of its
  /// steps is done, its `to` cut if all its steps are done, and otherwise a mixed cut. If no step of an
  /// instance was done since the last call, the instance keeps its mixed cut.
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
  std::vector<Mixture> mixtures_;  ///< for each instance, the mixture of old and new parts that it draws now
};

}  // namespace lode::render
