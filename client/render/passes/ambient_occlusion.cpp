#include "client/render/passes/ambient_occlusion.h"

#include <cmath>

#include "client/render/gl/shader_program.h"

namespace lode::render {
namespace {

// The shaders below run in this order. They read the picture's depth, which is reversed and has no far plane:
// it is 1 at the near plane, 0 in the background, and an affine function of x and y on a planar surface.

enum OcclusionUniform { kOcclusionMiddle, kOcclusionRayStep, kOcclusionReach };
enum BlurUniform { kBlurAlong };
enum DarkeningUniform { kDarkeningSamples };

/// Shader that halves the resolution of the depth. Takes every second pixel of every second row, and averages
/// its depth with pairs of opposite neighbours. On a planar surface, the mean depth of such a pair equals the
/// depth of the pixel. A pair with a different mean, as across an edge, is left out. Averaging also merges
/// the two surfaces that a cross-fade dithers.
const char* const kHalvingShader = R"glsl(
layout(binding = 1) uniform sampler2DMS depths;
out float depth;

const float kOneSurface = 0.02;  // relative depth difference within a surface

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

/// Shader that computes the share of the sky that is visible from a pixel's surface. Lengths are relative to
/// the reach, the radius of the occlusion, which grows in proportion to the distance from the eye.
const char* const kOcclusionShader = R"glsl(
layout(binding = 2) uniform sampler2D depths;
layout(location = 0) uniform vec2 middle_px;
// Distance between the rays of neighbouring pixels, at distance 1 from the eye.
layout(location = 1) uniform float ray_step;
layout(location = 2) uniform float reach_px;
out vec2 open_depth;  // visible share of the sky, and depth

const int kTaps = 12;
const float kTurn = 6.28318531;
const mat2 kGoldenTurn = mat2(-0.73736888, 0.67549029, -0.67549029, -0.73736888);
// Bend of the depth, relative to the depth, above which the normal is unknown.
const float kOneSurface = 0.02;
// Height above the surface, relative to the reach, up to which geometry hides nothing.
const float kBias = 0.02;
const float kSoftening = 0.02, kStrength = 3.0;

float depthAt(ivec2 pixel) {
  bool is_inside = all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, textureSize(depths, 0)));
  return is_inside ? texelFetch(depths, pixel, 0).r : 0.0;
}

vec2 rayThrough(vec2 pixel) { return (pixel + 0.25 - middle_px) * ray_step; }

/// Returns the change of depth per pixel and the bend, which is the second difference of the depth. Uses the
/// two pixels on the side with the smaller bend.
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

  // Rotate the taps by one of 16 angles. Every block of 4 x 4 pixels contains each angle once, and the blur
  // averages over such a block.
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

/// Shader that blurs along one axis, over the length of the 4 x 4 pattern of kOcclusionShader. A pixel has
/// more weight if its depth is near the plane of the middle pixel's surface.
const char* const kOcclusionBlurShader = R"glsl(
layout(binding = 2) uniform sampler2D open_depths;
layout(location = 0) uniform ivec2 along;
out vec2 open_depth;

const int kReach = 2;  // half the side of the 4 x 4 pattern
const float kOneSurface = 0.02;  // relative depth difference within a surface

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

/// Shader that multiplies a pixel by the mean light of its samples. Interpolates the light of a sample from
/// the pixels of the half-size layer, mostly from pixels of similar depth.
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
  if (!(light < 0.998)) discard;  // skip factors near 1, which would change the colours by rounding only
  factor = vec4(vec3(light), 1.0);
}
)glsl";

/// Radius of the occlusion, relative to the picture's height.
constexpr float kReach = 0.07f;

enum HalfUnit : GLuint { kPictureDepth = 1, kHalfLayer };

}  // namespace

AmbientOcclusion::AmbientOcclusion()
    : halving_program_(linkProgram(kFullScreenVertexShader, {kHalvingShader})),
      occlusion_program_(linkProgram(kFullScreenVertexShader, {kOcclusionShader})),
      blur_program_(linkProgram(kFullScreenVertexShader, {kOcclusionBlurShader})),
      darkening_program_(linkProgram(kFullScreenVertexShader, {kDarkeningShader})),
      empty_array_(GlVertexArray::create()) {}

AmbientOcclusion::Layer AmbientOcclusion::makeLayer(GLenum format, uint32_t width_px, uint32_t height_px) {
  Layer layer{GlTexture::create(), GlFramebuffer::create()};
  const GLuint texture = layer.texture.get();
  glTextureStorage2D(texture, 1, format, static_cast<GLsizei>(width_px), static_cast<GLsizei>(height_px));
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(texture, filter, GL_NEAREST);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTextureParameteri(texture, wrap, GL_CLAMP_TO_EDGE);
  glNamedFramebufferTexture(layer.framebuffer.get(), GL_COLOR_ATTACHMENT0, texture, 0);
  return layer;
}

void AmbientOcclusion::fit(const Framebuffer& picture) {
  const uint32_t width_px = (picture.widthPx() + 1) / 2, height_px = (picture.heightPx() + 1) / 2;
  if (width_px == width_px_ && height_px == height_px_) return;
  width_px_ = width_px;
  height_px_ = height_px;
  depth_ = makeLayer(GL_R32F, width_px, height_px);
  occlusion_ = makeLayer(GL_RG32F, width_px, height_px);
  blurred_ = makeLayer(GL_RG32F, width_px, height_px);
}

void AmbientOcclusion::drawLayer(const Layer& layer, const GlProgram& program) const {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, layer.framebuffer.get());
  glUseProgram(program.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

/// Computes the layers from the bound depth.
void AmbientOcclusion::drawLayers() const {
  glDisable(GL_DEPTH_TEST);
  glViewport(0, 0, static_cast<GLsizei>(width_px_), static_cast<GLsizei>(height_px_));
  drawLayer(depth_, halving_program_);
  glBindTextureUnit(kHalfLayer, depth_.texture.get());
  drawLayer(occlusion_, occlusion_program_);
  glBindTextureUnit(kHalfLayer, occlusion_.texture.get());
  glProgramUniform2i(blur_program_.get(), kBlurAlong, 1, 0);
  drawLayer(blurred_, blur_program_);
  glBindTextureUnit(kHalfLayer, blurred_.texture.get());
  glProgramUniform2i(blur_program_.get(), kBlurAlong, 0, 1);
  drawLayer(occlusion_, blur_program_);
  glBindTextureUnit(kHalfLayer, occlusion_.texture.get());
}

void AmbientOcclusion::darken(const Framebuffer& picture, double fov_y_rad, ColorMode show) {
  if (show != ColorMode::kSurface) return;
  fit(picture);
  const float half_height = 0.5f * static_cast<float>(picture.heightPx());
  const glm::vec2 middle_px = 0.25f * glm::vec2(picture.widthPx(), picture.heightPx());
  const auto ray_step = static_cast<float>(2 * std::tan(fov_y_rad / 2) / half_height);
  glProgramUniform2f(occlusion_program_.get(), kOcclusionMiddle, middle_px.x, middle_px.y);
  glProgramUniform1f(occlusion_program_.get(), kOcclusionRayStep, ray_step);
  glProgramUniform1f(occlusion_program_.get(), kOcclusionReach, kReach * half_height);

  glBindVertexArray(empty_array_.get());
  glBindTextureUnit(kPictureDepth, picture.depth());
  drawLayers();

  picture.bindForDrawing();
  glEnable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ZERO, GL_SRC_COLOR);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_LESS);  // skips background samples, which have the same depth 0 as the drawn triangle
  glUseProgram(darkening_program_.get());
  glProgramUniform1i(darkening_program_.get(), kDarkeningSamples, picture.samples());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDepthMask(GL_TRUE);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glBindVertexArray(0);
}

}  // namespace lode::render
