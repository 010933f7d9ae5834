#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "client/core/lod/cut.h"

namespace lode::render {

/// A part of the newer cut at a place where the model stands.
struct InstancePart {
  uint32_t instance = 0;
  uint32_t number = 0;  ///< for core::partOf()
};

/// Parts of the newer cuts whose meshes have to be there together.
struct ExchangeStep {
  std::vector<InstancePart> parts;
  uint32_t instance = 0;          ///< of the region
  std::optional<NodeKey> region;  ///< that changes hands then; none: all that is whole, or the fallbacks
};

/// How the cuts of a model at its places take the places of others: region by region, each as soon as all
/// that it shows is on the GPU, those first that are in sight and were coarsest, wherever they stand. In
/// between a mixture of both covers the model, of each region the newer or the older cut's parts, which is as
/// free of holes as they are: where it leaves places out, a fallback of either stands by. Needs no OpenGL.
class CutExchange {
 public:
  using Cuts = std::vector<std::shared_ptr<const core::Cut>>;  ///< by place

  /// @param from  of the same build and number as `to`; none: all of `to` is one step.
  CutExchange(Cuts from, Cuts to);

  std::span<const ExchangeStep> steps() const noexcept { return steps_; }
  /// What to draw once the first `steps` are done: at a place where none are `from`, where all are `to`, else
  /// their mixture, with the parts of both; one that was made before where no more are done.
  Cuts after(size_t steps);

 private:
  struct Mixture {
    size_t steps = 0;  ///< that are done at the place
    std::shared_ptr<const core::Cut> cut;
  };

  void planRegions();
  std::shared_ptr<const core::Cut> mixtureAt(uint32_t instance, std::vector<NodeKey> regions_left) const;

  Cuts from_, to_;
  std::vector<ExchangeStep> steps_;
  std::vector<Mixture> mixtures_;  ///< by place, the last
};

}  // namespace lode::render
