#include "client/render/passes/ambient_occlusion_shaders.h"

namespace lode::render {

/// Every second pixel of every second row, smoothed with its neighbours: by pairs on opposite sides, which
/// change nothing on what is flat, also beside its rim, and where what fades shows two surfaces by turns make
/// them one.
const char* const kHalvingShader = R"glsl(
layout(binding = 1) uniform sampler2DMS depths;
out float depth;

const float kOneSurface = 0.02;  // of the depth

float depthAt(ivec2 pixel) {
  ivec2 size = textureSize(depths);
  bool is_inside = all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, size));
  return is_inside ? texelFetch(depths, pixel, 0).r : 0.0;
}

void main() {
  ivec2 pixel = 2 * ivec2(gl_FragCoord.xy);
  float middle = depthAt(pixel), sum = middle, count = 1.0;
  depth = middle;
  if (middle == 0.0) return;
  const ivec2 kSides[4] = ivec2[](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1));
  for (int side = 0; side < 4; ++side) {
    float pair = depthAt(pixel + kSides[side]) + depthAt(pixel - kSides[side]);
    if (abs(pair - 2.0 * middle) > kOneSurface * middle) continue;
    sum += pair;
    count += 2.0;
  }
  depth = sum / count;
}
)glsl";

/// Lengths are in shares of the reach, which grows with the distance from the eye as what a pixel covers
/// does.
const char* const kOcclusionShader = R"glsl(
layout(binding = 2) uniform sampler2D depths;
layout(location = 0) uniform vec2 middle_px;
layout(location = 1) uniform float ray_step;  // between the rays through neighbouring pixels, at distance 1
layout(location = 2) uniform float reach_px;
out vec2 open_depth;  // what is open of the sky

const int kTaps = 12;
const float kTurn = 6.28318531;
const mat2 kGoldenTurn = mat2(-0.73736888, 0.67549029, -0.67549029, -0.73736888);
const float kOneSurface = 0.02;  // of the depth: what bends more has no side that is known
const float kBias = 0.02;  // of the reach: what is no higher hides nothing
const float kSoftening = 0.02, kStrength = 3.0;

float depthAt(ivec2 pixel) {
  bool is_inside = all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, textureSize(depths, 0)));
  return is_inside ? texelFetch(depths, pixel, 0).r : 0.0;
}

vec2 rayThrough(vec2 pixel) { return (pixel + 0.25 - middle_px) * ray_step; }

/// How depth changes from a pixel to the next, by the two on that side on which it bends less; and that bend.
vec2 slopeAndBend(ivec2 pixel, ivec2 along, float depth) {
  float after = depthAt(pixel + along), after_next = depthAt(pixel + 2 * along);
  float before = depthAt(pixel - along), before_last = depthAt(pixel - 2 * along);
  vec2 on_after = vec2(0.5 * (after_next - depth), abs(after_next - 2.0 * after + depth));
  vec2 on_before = vec2(0.5 * (depth - before_last), abs(before_last - 2.0 * before + depth));
  return on_after.y < on_before.y ? on_after : on_before;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float depth = depthAt(pixel);
  open_depth = vec2(1.0, depth);
  if (depth == 0.0) return;
  vec3 point = vec3(rayThrough(vec2(pixel)), -1.0);
  vec2 across = slopeAndBend(pixel, ivec2(1, 0), depth), up = slopeAndBend(pixel, ivec2(0, 1), depth);
  float known = max(1.0 - max(across.y, up.y) / (kOneSurface * depth), 0.0);
  vec2 change = vec2(across.x, up.x) / ray_step;
  vec3 normal = normalize(vec3(-change, depth - dot(change, point.xy)));

  // Sixteen turns of the taps, each once in any square of four by four pixels, for the blur to make them one.
  int turn = 4 * (pixel.x + pixel.y & 3) + (pixel.x + 2 * pixel.y & 3);
  float angle = kTurn / 16.0 * float(turn), start = (float(turn) + 0.5) / 16.0;
  vec2 direction = vec2(cos(angle), sin(angle));
  float hidden = 0.0;
  for (int tap = 0; tap < kTaps; ++tap) {
    ivec2 at = pixel + ivec2(round(reach_px * (float(tap) + start) / float(kTaps) * direction));
    at = clamp(at, ivec2(0), textureSize(depths, 0) - 1);
    direction = kGoldenTurn * direction;
    float nearness = max(texelFetch(depths, at, 0).r / depth, 1e-3);
    vec3 way = (vec3(rayThrough(vec2(at)), -1.0) / nearness - point) / (reach_px * ray_step);
    float square = dot(way, way), within = max(1.0 - square, 0.0);
    hidden += within * within * within * max(dot(way, normal) - kBias, 0.0) / (square + kSoftening);
  }
  open_depth.x = 1.0 / (1.0 + kStrength / float(kTaps) * known * hidden);
}
)glsl";

/// Along one axis, over one length of the pattern, of what lies on the flat continuation of the pixel's
/// surface.
const char* const kOcclusionBlurShader = R"glsl(
layout(binding = 2) uniform sampler2D open_depths;
layout(location = 0) uniform ivec2 along;
out vec2 open_depth;

const int kReach = 2;  // half a pattern
const float kOneSurface = 0.02;  // of the depth

vec2 at(int step) {
  ivec2 pixel = ivec2(gl_FragCoord.xy) + step * along;
  ivec2 size = textureSize(open_depths, 0);
  bool is_inside = all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, size));
  return is_inside ? texelFetch(open_depths, pixel, 0).rg : vec2(1.0, 0.0);
}

void main() {
  vec2 middle = at(0);
  open_depth = middle;
  if (middle.y == 0.0) return;
  float after = at(1).y - middle.y, before = middle.y - at(-1).y;
  float slope = abs(after) < abs(before) ? after : before;
  float sum = middle.x, weights = 1.0;
  for (int step = -kReach; step <= kReach; ++step) {
    if (step == 0) continue;
    vec2 other = at(step);
    float stray = abs(other.y - middle.y - slope * float(step)) / (kOneSurface * middle.y);
    float weight = (abs(step) == kReach ? 0.5 : 1.0) * max(1.0 - stray, 0.0);
    sum += weight * other.x;
    weights += weight;
  }
  open_depth.x = sum / weights;
}
)glsl";

/// A pixel gets the mean of what its samples' surfaces get.
const char* const kDarkeningShader = R"glsl(
layout(binding = 1) uniform sampler2DMS depths;
layout(binding = 2) uniform sampler2D open_depths;
layout(location = 0) uniform int samples;
out vec4 factor;

const float kOneSurface = 0.02, kLeastShare = 0.02, kLeastWeight = 1e-3;

void main() {
  vec2 at = gl_FragCoord.xy * 0.5 - 0.25, corner = floor(at), part = at - corner;
  vec2 place = (corner + 1.0) / vec2(textureSize(open_depths, 0));
  vec4 open = textureGather(open_depths, place, 0), near = textureGather(open_depths, place, 1);
  vec4 shares = vec4(1.0 - part.x, part.x, part.x, 1.0 - part.x) * vec4(part.yy, 1.0 - part.yy);
  shares += kLeastShare;
  float sum = 0.0, count = 0.0;
  for (int number = 0; number < samples; ++number) {
    float depth = texelFetch(depths, ivec2(gl_FragCoord.xy), number).r;
    if (depth == 0.0) continue;
    vec4 weights = shares * max(1.0 - abs(near / depth - 1.0) / kOneSurface, kLeastWeight);
    sum += dot(weights, open) / dot(weights, vec4(1.0));
    count += 1.0;
  }
  float light = sum / count;
  if (!(light < 0.998)) discard;  // colours that are multiplied by about 1 would be rounded
  factor = vec4(vec3(light), 1.0);
}
)glsl";

}  // namespace lode::render
