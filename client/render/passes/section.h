#pragma once

#include <glm/glm.hpp>

namespace lode::render {

/// A plane that cuts a model open. The half where dot(normal, position) > offset_model is not drawn. The cut
/// surface of a solid is drawn in one colour, wherever the nearest surface behind the plane shows its back
/// face. The faces of the model must therefore be counter-clockwise as seen from outside.
struct Section {
  glm::dvec3 normal{1, 0, 0};               ///< unit length, in the model frame
  double offset_model = 0;                  ///< distance of the plane from the origin of the model frame
  glm::vec3 cap_srgb{0.80f, 0.45f, 0.35f};  ///< colour of the cut, 0 to 1

  bool operator==(const Section&) const = default;
};

}  // namespace lode::render
