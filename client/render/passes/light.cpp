#include "client/render/passes/light.h"

#include "client/render/eye.h"

namespace lode::render {

Light lightFor(const core::View& view, const glm::dvec3& up) noexcept {
  const glm::dvec3 above = glm::normalize(up), right = glm::cross(view.forward, view.up);
  // Towards the viewer over level ground; of a camera that is rolled by a quarter turn, towards its eye.
  const glm::dvec3 level = glm::cross(right, above);
  const glm::dvec3 back = glm::length(level) > 0.1 ? glm::normalize(level) : -view.forward;
  const glm::dvec3 left = glm::cross(back, above);
  const glm::mat3 rotation = viewRotation(view);
  return {rotation * glm::vec3(glm::normalize(0.35 * left + 0.78 * above + 0.52 * back)),
          rotation * glm::vec3(above)};
}

}  // namespace lode::render
