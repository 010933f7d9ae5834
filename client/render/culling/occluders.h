#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/view/view.h"
#include "client/render/eye.h"

namespace lode::render {

/// The depth of what is farthest in each square of a picture: reversed, 0 where the background shows in it.
struct FarthestDepths {
  static constexpr uint32_t kSquarePx = 8;
  uint32_t columns = 0, rows = 0;
  std::vector<float> depths;  ///< by rows, the lowest first
};

/// Tells what cannot be seen because of what is drawn already. Pure.
class Occluders {
 public:
  /// @param step   of the model's lattice, as it was drawn with.
  /// @param drawn  of all that was drawn; must outlive this. Of no squares: nothing hides.
  Occluders(const core::View& view, double step, const FarthestDepths& drawn);
  Occluders(const core::View& view, double step, const FarthestDepths&& drawn) = delete;  ///< is gone at once

  /// True only if all that lies in the box is behind what is drawn, at each sample of the picture.
  bool hide(const core::ModelBox& box) const noexcept;

 private:
  const FarthestDepths& drawn_;
  const glm::dvec3 eye_, forward_, right_, up_;  ///< right_ and up_ in pixels at unit distance
  const glm::dvec2 size_px_;
  const double near_model_;
};

}  // namespace lode::render
