#include "client/render/passes/light.h"

#include <cmath>

#include "client/render/gl/eye.h"

namespace lode::render {

namespace {

/// Turns a direction of the view frame to the right and down.
glm::vec3 turned(const glm::vec3& direction, const glm::vec2& turn_rad) noexcept {
  const float down = std::cos(turn_rad.y), down_sine = std::sin(turn_rad.y);
  const glm::vec3 lowered(direction.x, direction.y * down - direction.z * down_sine,
                          direction.y * down_sine + direction.z * down);
  const float right = std::cos(turn_rad.x), right_sine = std::sin(turn_rad.x);
  return {lowered.x * right + lowered.z * right_sine, lowered.y, lowered.z * right - lowered.x * right_sine};
}

}  // namespace

Light lightFor(const core::View& view, const glm::dvec3& up, const glm::dvec2& turn_rad) noexcept {
  const glm::dvec3 above = glm::normalize(up), right = glm::cross(view.forward, view.up);
  // `back` is the horizontal direction towards the viewer. If the camera is rolled by 90 degrees, `back` is
  // opposite to the view direction.
  const glm::dvec3 level = glm::cross(right, above);
  const glm::dvec3 back = glm::length(level) > 0.1 ? glm::normalize(level) : -view.forward;
  const glm::dvec3 left = glm::cross(back, above);
  const glm::mat3 rotation = viewRotation(view);
  const glm::vec3 to_sun = rotation * glm::vec3(glm::normalize(0.35 * left + 0.78 * above + 0.52 * back));
  return {turn_rad == glm::dvec2(0) ? to_sun : turned(to_sun, turn_rad), rotation * glm::vec3(above)};
}

const char* const kLightShader = R"glsl(
layout(location = 7) uniform vec3 to_sun;
layout(location = 8) uniform vec3 up;
layout(location = 9) uniform float exposure;

const vec3 kSun = vec3(0.84, 0.80, 0.73), kSky = vec3(0.30, 0.335, 0.385), kGround = vec3(0.095, 0.085, 0.075);
const float kHeadlight = 0.08, kGlint = 0.05, kShoulder = 0.55;

/// Returns the light that a surface of this colour and normal sends to the eye.
vec3 lit(vec3 paint, vec3 n, vec3 to_eye) {
  vec3 light = mix(kGround, kSky, dot(n, up) * 0.5 + 0.5);
  light += kSun * max(dot(n, to_sun), 0.0) + kHeadlight * max(dot(n, to_eye), 0.0);
  float facing = max(dot(n, normalize(to_sun + to_eye)), 0.0);
  float square = facing * facing, eighth = square * square * square * square;
  float glint = eighth * eighth * eighth * eighth * eighth;  // `facing` to the power of 40
  return exposure * (paint * light + kGlint * glint);
}

/// Compresses colours above the shoulder to values below 1, so that sunlit white keeps its shading (tone
/// mapping). Scales all three channels by the same factor, so that the hue stays the same.
vec3 toned(vec3 colour) {
  float most = max(colour.r, max(colour.g, colour.b)), room = 1.0 - kShoulder;
  if (most <= kShoulder) return colour;
  return colour * ((kShoulder + room * (1.0 - exp((kShoulder - most) / room))) / most);
}
)glsl";

}  // namespace lode::render
