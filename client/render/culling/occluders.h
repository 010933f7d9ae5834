#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/view/view.h"
#include "client/render/gl/eye.h"

namespace lode::render {

/// Farthest depth in each square of a picture. Depths are reversed: the background has depth 0.
struct FarthestDepths {
  static constexpr uint32_t kSquarePx = 8;
  uint32_t columns = 0, rows = 0;
  std::vector<float> depths;  ///< depths row by row, bottom row first
};

/// Tests on the CPU whether drawn geometry hides boxes.
class Occluders {
 public:
  /// @param step   the model's lattice step.
  /// @param drawn  depths of the picture; must outlive this object. Empty depths hide nothing.
  Occluders(const core::View& view, double step, const FarthestDepths& drawn);
  /// Deleted, because drawn_ would dangle.
  Occluders(const core::View& view, double step, const FarthestDepths&& drawn) = delete;

  /// Returns true only if the whole box is behind drawn geometry at every sample.
  bool hide(const core::ModelBox& box) const noexcept;

 private:
  const FarthestDepths& drawn_;
  /// right_ and up_ are scaled so that a dot product with them, divided by the distance, is in pixels.
  const glm::dvec3 eye_, forward_, right_, up_;
  const glm::dvec2 size_px_;
  const double near_model_;
};

}  // namespace lode::render
