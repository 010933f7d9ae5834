#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "client/core/cut.h"

namespace lode::render {

/// Meshes of the newer cut that have to be there together.
struct ExchangeStep {
  std::vector<uint32_t> numbers;  ///< for core::partOf()
  std::optional<NodeKey> region;  ///< that changes hands then; none: the newer cut's fallbacks
};

/// How one cut takes another's place: region by region, each as soon as all that it shows there is on the
/// GPU, those first that are in sight and were coarsest. In between a mixture of both covers the model, of
/// each region the newer or the older cut's parts, which is as free of holes as they are: where it leaves
/// places out, a fallback of either stands by. Needs no OpenGL.
class CutExchange {
 public:
  /// @param from  of the same build as `to`; null: all of `to` is one step.
  CutExchange(std::shared_ptr<const core::Cut> from, std::shared_ptr<const core::Cut> to);

  std::span<const ExchangeStep> steps() const noexcept { return steps_; }
  /// What to draw once the first `steps` are done, `from` for none and `to` for all. It keeps both alive, so
  /// that no mesh is freed with it. Its tiles are those of both.
  std::shared_ptr<const core::Cut> after(size_t steps) const;

 private:
  struct Mixture;

  void planRegions();

  std::shared_ptr<const core::Cut> from_, to_;
  std::vector<ExchangeStep> steps_;
};

}  // namespace lode::render
