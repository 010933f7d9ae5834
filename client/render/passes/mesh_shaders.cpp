#include "client/render/passes/mesh_shaders.h"

namespace lode::render {

#define LODE_CORNER                                                                                       \
  "CORNER vec3 position_view; vec3 normal_view; vec3 normal_squares; vec3 normal_products; vec3 colour; " \
  "vec2 uv; flat uint material; flat uint flags; flat uint share;"

const char* const kCorner = LODE_CORNER;
const char* const kTintedCorner = LODE_CORNER " flat vec3 tint;";

const char* const kMeshVertexShader = R"glsl(
layout(location = 0) in uvec2 position_code;
layout(location = 1) in vec4 normal;
layout(location = 2) in vec4 colour_srgb;
layout(location = 3) in uvec3 draw_state;  // the fields of DrawState
layout(location = 4) in uvec3 texture_code;  // texture coordinates and material

layout(location = 0) uniform ivec3 eye_high;
layout(location = 1) uniform vec3 eye_low;
layout(location = 2) uniform float lattice_step;
layout(location = 3) uniform mat3 view_rotation;
layout(location = 4) uniform vec3 projection;  // scale x, scale y and near distance
// Origin of texture coordinates, and size of a step of the quantized coordinates.
layout(location = 5) uniform vec3 uv_frame;

#ifdef SECTION
layout(location = 16) uniform vec4 section;  // normal in the view frame, and distance from the eye
#endif

invariant gl_Position;
out Corner { CORNER };

vec3 toLinear(vec3 srgb) {
  return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)), greaterThan(srgb, vec3(0.04045)));
}

void main() {
  ivec3 position = ivec3(position_code.x & 0x1fffffu,
                         position_code.x >> 21 | (position_code.y & 0x3ffu) << 11,
                         position_code.y >> 10 & 0x1fffffu);
  // The integer difference is exact, so that nodes draw a shared vertex at the same place and no gap opens.
  vec3 relative = (vec3(position - eye_high) - eye_low) * lattice_step;
  position_view = view_rotation * relative;
  normal_view = view_rotation * normal.xyz;
  normal_squares = normal_view * normal_view;
  normal_products = normal_view.yzx * normal_view.zxy;
  colour = toLinear(colour_srgb.rgb);
  uv = uv_frame.xy + vec2(texture_code.xy) * uv_frame.z;
  material = texture_code.z;
  flags = draw_state.x;
#ifdef VIEWS
  tint = (flags & 4u) != 0u ? toLinear(unpackUnorm4x8(draw_state.y).rgb) : vec3(0.0);
#endif
  share = draw_state.z;
  gl_Position = vec4(projection.xy * position_view.xy, projection.z, -position_view.z);
#ifdef SECTION
  gl_ClipDistance[0] = section.w - dot(section.xyz, position_view);
#endif
}
)glsl";

const char* const kMeshFragmentShader = R"glsl(
#ifdef WIRE
in OfTriangle { CORNER };
#else
in Corner { CORNER };
#endif
out vec4 pixel;

layout(location = 3) uniform mat3 view_rotation;
#ifdef VIEWS
// Colours for 1/4, 1/2, 1, 2 and 4 texels per pixel, then the colour for surfaces without a texture.
layout(location = 10) uniform vec3 texel_colours[6];
#endif

#ifdef SECTION
layout(location = 16) uniform vec4 section;
layout(location = 17) uniform vec3 cap_srgb;
#endif

const vec3 kNeutral = vec3(0.56, 0.545, 0.515);
#ifdef TEXTURED
layout(location = 6) uniform uint texture_count;
layout(binding = 0) uniform sampler2DArray tile_layers;
layout(std430, binding = 0) readonly buffer TileTable { uint table[]; };

const uint kHeadWords = 4u, kTilePx = 512u, kInnerPx = 508u, kGutterPx = 2u, kCellPx = 32u;
const float kMostTaps = 8.0;

/// Samples one level of a texture. `at` is the position in the image, from (0, 0) in the top left corner to
/// (1, 1).
/// @return false if the tile is not resident.
bool sampleLevel(uint level, vec2 at, out vec4 texel) {
  uint head = material * kHeadWords;
  uvec2 size = (uvec2(table[head], table[head + 1u]) + (1u << level) - 1u) >> level;
  uvec2 tiles = (size + kInnerPx - 1u) / kInnerPx;
  vec2 place = at * vec2(size);
  uvec2 tile = min(uvec2(place) / kInnerPx, tiles - 1u);
  uint page = table[table[table[head + 3u] + level] + tile.y * tiles.x + tile.x];
  if (page >> 31 == 0u) return false;
  uvec2 corner = uvec2(page & 15u, page >> 4 & 15u) * kCellPx;
  vec2 in_layer = vec2(corner + kGutterPx) + (place - vec2(tile * kInnerPx));
  texel = textureLod(tile_layers, vec3(in_layer / float(kTilePx), float(page >> 8 & 0x7fffffu)), 0.0);
  return true;
}

/// Samples level floor(wanted) and blends it with the next coarser level. If that level is not resident,
/// samples the finest coarser level that is.
/// @return false if no level is resident.
bool samplePoint(vec2 at, float wanted, uint levels, out vec4 texel) {
  uint finest = uint(wanted), level = finest;
  while (!sampleLevel(level, at, texel))
    if (++level == levels) return false;
  vec4 coarser;
  if (level == finest && level + 1u < levels && sampleLevel(level + 1u, at, coarser))
    texel = mix(texel, coarser, wanted - float(finest));
  return true;
}

/// Samples the material's texture with anisotropic filtering. At a grazing angle, takes several samples along
/// the longer side of the pixel's footprint, at the level of the shorter side, to avoid blur.
/// Source: McCormack et al., Feline: Fast Elliptical Lines for Anisotropic Texture Mapping, 1999.
bool sampleTexture(out vec4 texel) {
  vec2 across = dFdx(uv), down = dFdy(uv);
  if (material >= texture_count) return false;
  uint head = material * kHeadWords, levels = table[head + 2u];
  if (levels == 0u) return false;
  vec2 size = vec2(table[head], table[head + 1u]);
  vec2 across_px = across * size, down_px = down * size;
  bool is_across = dot(across_px, across_px) > dot(down_px, down_px);
  float longer_px = max(max(length(across_px), length(down_px)), 1e-6);
  float shorter_px = max(abs(determinant(mat2(across_px, down_px))) / longer_px, 1.0);
  float reach = min(1.0, 2.0 * kMostTaps * shorter_px / longer_px);
  longer_px *= reach;
  float taps = clamp(floor(longer_px / shorter_px + 0.5), 1.0, kMostTaps);
  float wanted = clamp(log2(longer_px / taps), 0.0, float(levels - 1u));
  vec2 side = (is_across ? across : down) * reach;
  vec4 sum = vec4(0.0);
  for (float tap = 0.5; tap < taps; tap += 1.0) {
    vec2 at = uv + side * (tap / taps - 0.5);
    if (!samplePoint(fract(vec2(at.x, 1.0 - at.y)), wanted, levels, texel)) return false;
    sum += texel;
  }
  texel = sum / taps;
  return true;
}

#ifdef VIEWS
/// Returns the colour for the number of texels of the finest level along a pixel's side.
vec3 texelColour() {
  vec2 across = dFdx(uv), down = dFdy(uv);
  if (material >= texture_count || table[material * kHeadWords + 2u] == 0u) return texel_colours[5];
  vec2 size = vec2(table[material * kHeadWords], table[material * kHeadWords + 1u]);
  float texels = sqrt(abs(determinant(mat2(across * size, down * size))));
  float step = clamp(log2(max(texels, 1e-6)) + 2.0, 0.0, 4.0);
  int lower = min(int(step), 3);
  return mix(texel_colours[lower], texel_colours[lower + 1], step - float(lower));
}
#endif
#endif

/// Returns the vertex normal, flipped to the visible side, because both sides are lit. Normals that point to
/// opposite sides would cancel each other when interpolated. In that case, returns the sum of (n . facet) n
/// over the vertex normals n, in which the sign of n does not matter. The interpolated products of the
/// components of n give this sum.
vec3 shownNormal(vec3 facet) {
  float agreement = dot(normal_view, normal_view) / max(dot(normal_squares, vec3(1.0)), 1e-6);
  vec3 mixed = normal_view * (dot(normal_view, facet) < 0.0 ? -1.0 : 1.0);
  if (agreement > 0.5) return normalize(mixed);
  vec3 turned = normal_squares * facet + normal_products.zxy * facet.yzx + normal_products.yzx * facet.zxy;
  return normalize(mix(normalize(turned + 1e-4 * facet), mixed, smoothstep(0.25, 0.5, agreement)));
}

/// Returns true if the pixel's dither value is in the range of the draw call. The dither value depends only
/// on the pixel's position, so that adjacent ranges neither overlap nor leave gaps. Source: Jimenez, Next
/// Generation Post-Processing in Call of Duty: Advanced Warfare, 2014 (interleaved gradient noise).
bool isShared() {
  float noise = fract(52.9829189 * fract(dot(floor(gl_FragCoord.xy), vec2(0.06711056, 0.00583715))));
  uint place = min(uint(noise * 256.0), 255u);
  return place >= (share & 0xffffu) && place < share >> 16;
}

#ifdef VIEWS
const vec3 kClay = vec3(0.21, 0.205, 0.195);

/// Returns the colour of a studio-lit sphere where its normal is n (a matcap): a key light from the upper left, a
/// cool light along the rim. The light does not depend on the model's up axis.
vec3 matcap(vec3 n, vec3 to_eye) {
  vec3 right = normalize(vec3(to_eye.z, 0.0, -to_eye.x));
  vec3 on_sphere = vec3(dot(n, right), dot(n, cross(to_eye, right)), dot(n, to_eye));
  float key = max(dot(on_sphere, vec3(-0.42, 0.62, 0.663)), 0.0);
  float rim = 1.0 - clamp(on_sphere.z, 0.0, 1.0);
  float bright = pow(key, 32.0);
  return vec3(0.30, 0.27, 0.25) * (0.06 + 0.85 * key) + 0.18 * bright + vec3(0.10, 0.14, 0.20) * rim * rim * rim;
}
#endif

void main() {
#ifdef FADING
  if (!isShared()) discard;
#endif
#ifdef SECTION
  // The nearest surface behind the plane is seen from its back: the ray has met the plane inside a solid.
  float along = section.w / dot(section.xyz, position_view);
  if (!gl_FrontFacing && section.w < 0.0 && along > 0.0 && along < 1.0) {
    pixel = vec4(pow(cap_srgb, vec3(2.2)), 1.0);
    return;
  }
#endif
  vec3 to_eye = normalize(-position_view);
  vec3 facet = normalize(cross(dFdx(position_view), dFdy(position_view)));
  if (dot(facet, to_eye) < 0.0) facet = -facet;
  vec3 n = facet;
  if ((flags & 1u) != 0u && dot(normal_squares, vec3(1.0)) > 1e-6) n = shownNormal(facet);
  vec3 albedo = (flags & 2u) != 0u ? colour : kNeutral;
  float coverage = 1.0;  // alpha of the pixel, for alpha to coverage
#ifdef TEXTURED
  vec4 texel;
  if ((flags & 8u) != 0u && sampleTexture(texel)) {
    albedo = (flags & 2u) != 0u ? colour * texel.rgb : texel.rgb;
    coverage = texel.a;
  }
#endif
#ifdef CUT_OUT
  if (coverage < 0.5) discard;
  coverage = 1.0;
#endif
#ifndef VIEWS
  pixel = vec4(toned(lit(albedo, n, to_eye)), coverage);
#else
  if ((flags & 64u) != 0u) albedo = texel_colours[5];
#ifdef TEXTURED
  if ((flags & 72u) == 72u) albedo = texelColour();
#endif
  if ((flags & 4u) != 0u) albedo = tint;
  if ((flags & 128u) != 0u) albedo = kClay;
  vec3 seen = toned(lit(albedo, n, to_eye));
  if ((flags & 16u) != 0u) seen = albedo;
  if ((flags & 256u) != 0u) seen = toned(exposure * matcap(n, to_eye));
  // Show the normal in the model frame.
  if ((flags & 32u) != 0u) seen = pow((n * view_rotation) * 0.5 + 0.5, vec3(2.2));
#ifdef WIRE
  seen = withEdges(seen);
#endif
  pixel = vec4(seen, coverage);
#endif
}
)glsl";

const char* const kWireGeometryShader = R"glsl(
layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;

in Corner { CORNER } corner[];
out OfTriangle { CORNER };
out vec3 shares;  // barycentric coordinates

void main() {
  for (int i = 0; i < 3; ++i) {
    gl_Position = gl_in[i].gl_Position;
#ifdef SECTION
    gl_ClipDistance[0] = gl_in[i].gl_ClipDistance[0];
#endif
    position_view = corner[i].position_view;
    normal_view = corner[i].normal_view;
    normal_squares = corner[i].normal_squares;
    normal_products = corner[i].normal_products;
    colour = corner[i].colour;
    uv = corner[i].uv;
    material = corner[i].material;
    flags = corner[i].flags;
    tint = corner[i].tint;
    share = corner[i].share;
    shares = vec3(i == 0, i == 1, i == 2);
    EmitVertex();
  }
  EndPrimitive();
}
)glsl";

const char* const kWireShader = R"glsl(
#ifdef WIRE
in vec3 shares;

// Half of a line's width, in pixels, and its limit as a part of the triangle's least height. In small triangles,
// lines get thinner, so that the surface between them stays visible.
const float kHalfPx = 0.6, kMostOfHeight = 0.08;
// Least heights of a triangle below which its lines are replaced by their mean, and above which they are drawn.
const float kCrowdedPx = 1.5, kRoomyPx = 4.0;
const float kMeanCover = 0.4;  // part of a triangle that lines of width kMostOfHeight cover
const float kEdgeOpacity = 0.9;
// The surface below the edges: a little brighter than without them, so that dark edges show on dark paint.
const float kDimmed = 0.85, kLifted = 0.05;
const vec3 kEdge = vec3(0.004);

/// Returns the part of the pixel that the triangle's edges cover.
float edgeCover() {
  vec3 across = dFdx(shares), down = dFdy(shares);
  vec3 heights_px = inversesqrt(max(across * across + down * down, 1e-12));
  float height_px = min(min(heights_px.x, heights_px.y), heights_px.z);
  vec3 from_edges_px = abs(shares) * heights_px;
  float nearest_px = min(min(from_edges_px.x, from_edges_px.y), from_edges_px.z);
  float half_px = min(kHalfPx, kMostOfHeight * height_px);
  float cover = max(0.0, min(half_px, nearest_px + 0.5) - max(-half_px, nearest_px - 0.5));
  return mix(kMeanCover, cover, smoothstep(kCrowdedPx, kRoomyPx, height_px));
}

/// Draws the triangle's edges over the surface.
vec3 withEdges(vec3 surface) {
  return mix(surface * kDimmed + kLifted, kEdge, kEdgeOpacity * min(edgeCover(), 1.0));
}
#endif
)glsl";

}  // namespace lode::render
