#include "client/render/passes/shaders.h"

namespace lode::render {

const char* const kLightShader = R"glsl(
layout(location = 7) uniform vec3 to_sun;
layout(location = 8) uniform vec3 up;
layout(location = 9) uniform float exposure;

const vec3 kSun = vec3(0.84, 0.80, 0.73), kSky = vec3(0.30, 0.335, 0.385), kGround = vec3(0.095, 0.085, 0.075);
const float kHeadlight = 0.08, kGlint = 0.05, kShoulder = 0.55;

/// What a surface of this paint with this normal sends to the eye.
vec3 lit(vec3 paint, vec3 n, vec3 to_eye) {
  vec3 light = mix(kGround, kSky, dot(n, up) * 0.5 + 0.5);
  light += kSun * max(dot(n, to_sun), 0.0) + kHeadlight * max(dot(n, to_eye), 0.0);
  float facing = max(dot(n, normalize(to_sun + to_eye)), 0.0);
  float square = facing * facing, eighth = square * square * square * square;
  float glint = eighth * eighth * eighth * eighth * eighth;  // a power of 40, without a logarithm
  return exposure * (paint * light + kGlint * glint);
}

/// Colours above the shoulder come ever nearer to the brightest and do not reach it: what is white and in the
/// sun keeps its shading. All three parts shrink alike, so that a paint keeps its hue.
vec3 toned(vec3 colour) {
  float most = max(colour.r, max(colour.g, colour.b)), room = 1.0 - kShoulder;
  if (most <= kShoulder) return colour;
  return colour * ((kShoulder + room * (1.0 - exp((kShoulder - most) / room))) / most);
}
)glsl";

}  // namespace lode::render
