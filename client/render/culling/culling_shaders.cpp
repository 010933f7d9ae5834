#include "client/render/culling/culling_shaders.h"

namespace lode::render {

#define LODE_CHUNKS                                                                                       \
  "struct Chunk { uint first_box_word, clusters, first_index, index_count; int base_vertex; uint state, " \
  "instance; };"                                                                                          \
  "layout(std430, binding = 2) readonly buffer Chunks { Chunk chunks[]; };"

const char* const kFindShader = LODE_CHUNKS R"glsl(
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Page { uint page[]; };
// One bit per cluster; indexed by pass, then by chunk.
layout(std430, binding = 3) buffer Found { uvec2 found[]; };
layout(binding = 1) uniform sampler2D depths;

struct Camera {
  ivec4 eye_high;  // in lattice steps; w is 1 if there are depths that can hide boxes
  // The w components of right, up and behind hold scale x, scale y and the near distance in lattice steps.
  vec4 eye_low, right, up, behind;
};
struct CameraPair { Camera now, before; };
layout(std430, binding = 4) readonly buffer Cameras { CameraPair cameras[]; };  // indexed by instance

// Number of the pass. Pass 0 tests against the depths of the last picture, pass 1 against those of this
// picture.
layout(location = 0) uniform uint pass;
layout(location = 1) uniform uint chunks_of_pass;
layout(location = 2) uniform uint first_chunk;
// True if the page is small enough for this shader to read its boxes.
layout(location = 3) uniform bool has_boxes;
layout(location = 4) uniform vec2 depth_size_px;

const float kSlack = 1e-5;       // error of float coordinates, relative to the distance
const float kSlackPx = 1.0;      // rasterization exceeds a box by at most this distance
const float kDepthSlack = 1e-4;  // relative error of a drawn depth
// Smallest distance along the view direction, relative to the distance and size of a box; nearer boxes have
// too large float errors and count as visible.
const float kLeastNearness = 1e-2;
const float kSquarePx = 8.0;

shared uint bits[2];

struct Box { vec3 middle, half_size; };  // relative to the eye, in lattice steps

Box boxFrom(Camera camera, uint word) {
  ivec3 low = ivec3(page[word], page[word + 1u], page[word + 2u]) - camera.eye_high.xyz;
  ivec3 high = ivec3(page[word + 3u], page[word + 4u], page[word + 5u]) - camera.eye_high.xyz;
  return Box((vec3(low) + vec3(high)) * 0.5 - camera.eye_low.xyz, vec3(high - low) * 0.5);
}

bool isInPicture(Camera camera, Box box) {
  vec3 right = camera.right.xyz * camera.right.w, up = camera.up.xyz * camera.up.w, forward = -camera.behind.xyz;
  vec3 inward[5] = vec3[](forward, forward + right, forward - right, forward + up, forward - up);
  float slack = kSlack * (length(box.middle) + length(box.half_size)) * (1.0 + camera.right.w + camera.up.w);
  for (int side = 0; side < 5; ++side)
    if (dot(inward[side], box.middle) + dot(abs(inward[side]), box.half_size) < -slack) return false;
  return true;
}

/// Returns true only if the whole box is behind the drawn depths; see Occluders.
bool isHidden(Camera camera, Box box) {
  vec3 forward = -camera.behind.xyz;
  float nearest = dot(box.middle, forward) - dot(box.half_size, abs(forward));
  if (nearest < kLeastNearness * (length(box.middle) + length(box.half_size))) return false;
  float depth = camera.behind.w / nearest * (1.0 + kDepthSlack);
  if (depth >= 1.0) return false;
  vec2 least = vec2(1e30), most = vec2(-1e30);
  for (uint corner = 0u; corner < 8u; ++corner) {
    vec3 side = vec3(corner & 1u, corner >> 1 & 1u, corner >> 2) * 2.0 - 1.0;
    vec3 arm = box.middle + box.half_size * side;
    vec2 place = vec2(dot(arm, camera.right.xyz) * camera.right.w, dot(arm, camera.up.xyz) * camera.up.w);
    place /= dot(arm, forward);
    least = min(least, place);
    most = max(most, place);
  }
  vec2 last_square = ceil(depth_size_px / kSquarePx) - 1.0;
  vec2 low = (least * 0.5 + 0.5) * depth_size_px - kSlackPx, high = (most * 0.5 + 0.5) * depth_size_px + kSlackPx;
  ivec2 first = ivec2(clamp(floor(low / kSquarePx), vec2(0.0), last_square));
  ivec2 last = ivec2(clamp(floor(high / kSquarePx), vec2(0.0), last_square));
  int level = 0;
  while (any(greaterThan((last >> level) - (first >> level), ivec2(3)))) ++level;
  first >>= level;
  last >>= level;
  float farthest = 1.0;
  for (int row = first.y; row <= last.y; ++row)
    for (int column = first.x; column <= last.x; ++column)
      farthest = min(farthest, texelFetch(depths, ivec2(column, row), level).r);
  return farthest > depth;
}

bool isFound(uint place, uint number, Chunk chunk) {
  if (number >= chunk.clusters) return false;
  // Skip a cluster that pass 0 has found, because it is already drawn.
  if (pass == 1u && (found[place][number >> 5] >> (number & 31u) & 1u) != 0u) return false;
  if (!has_boxes) return true;
  uint word = chunk.first_box_word + number * 6u;
  Camera now = cameras[chunk.instance].now;
  if (!isInPicture(now, boxFrom(now, word))) return false;
  if (pass == 1u) return !isHidden(now, boxFrom(now, word));
  Camera before = cameras[chunk.instance].before;
  return before.eye_high.w == 0 || !isHidden(before, boxFrom(before, word));
}

void main() {
  uint number = gl_LocalInvocationIndex, place = first_chunk + gl_WorkGroupID.x;
  if (number < 2u) bits[number] = 0u;
  barrier();
  if (isFound(place, number, chunks[place])) atomicOr(bits[number >> 5], 1u << (number & 31u));
  barrier();
  if (number == 0u) found[place + pass * chunks_of_pass] = uvec2(bits[0], bits[1]);
}
)glsl";

const char* const kListShader = LODE_CHUNKS R"glsl(
layout(local_size_x = 256) in;
struct List { uint first_chunk, chunks, first_command; };
struct Command { uint count, instance_count, first_index; int base_vertex; uint base_instance; };
layout(std430, binding = 3) readonly buffer Found { uvec2 found[]; };
layout(std430, binding = 4) readonly buffer Lists { List lists[]; };
layout(std430, binding = 5) writeonly buffer Commands { Command commands[]; };
layout(std430, binding = 6) writeonly buffer Counts { uint counts[]; };
layout(std430, binding = 7) buffer Triangles { uint triangles[]; };

layout(location = 0) uniform uint pass;
layout(location = 1) uniform uint chunks_of_pass;
layout(location = 2) uniform uint commands_of_pass;
layout(location = 3) uniform uint lists_of_pass;
layout(location = 4) uniform uint triangles_place;
layout(location = 5) uniform uint first_list;

const uint kClusterIndices = 384u;

shared uint sums[256];
shared uint indices;

/// Returns the first cluster at or after `from` whose bit equals `is_found`; 64 if there is none.
uint next(uvec2 bits, uint from, bool is_found) {
  if (!is_found) bits = ~bits;
  if (from < 32u) {
    uint low = bits.x & (~0u << from);
    if (low != 0u) return uint(findLSB(low));
  }
  if (from >= 64u) return 64u;
  uint high = bits.y & (~0u << (from < 32u ? 0u : from - 32u));
  return high != 0u ? 32u + uint(findLSB(high)) : 64u;
}

/// Writes one draw command for each run of consecutive clusters whose bits are set.
void list(uvec2 bits, Chunk chunk, uint command) {
  uint drawn = 0u;
  for (uint first = next(bits, 0u, true); first < 64u;) {
    uint end = next(bits, first, false);
    uint count = min(end * kClusterIndices, chunk.index_count) - first * kClusterIndices;
    commands[command++] =
        Command(count, 1u, chunk.first_index + first * kClusterIndices, chunk.base_vertex, chunk.state);
    drawn += count;
    first = next(bits, end, true);
  }
  if (drawn > 0u) atomicAdd(indices, drawn);
}

void main() {
  uint thread = gl_LocalInvocationIndex, number = first_list + gl_WorkGroupID.x;
  List all = lists[number];
  if (thread == 0u) indices = 0u;
  uint listed = 0u;
  for (uint base = 0u; base < all.chunks; base += 256u) {
    bool is_there = base + thread < all.chunks;
    uint place = all.first_chunk + base + thread;
    uvec2 bits = is_there ? found[place + pass * chunks_of_pass] : uvec2(0u);
    uvec2 starts = bits & ~uvec2(bits.x << 1, bits.y << 1 | bits.x >> 31);
    uint runs = uint(bitCount(starts.x) + bitCount(starts.y));
    sums[thread] = runs;
    barrier();
    for (uint reach = 1u; reach < 256u; reach *= 2u) {
      uint before = thread >= reach ? sums[thread - reach] : 0u;
      barrier();
      sums[thread] += before;
      barrier();
    }
    uint command = pass * commands_of_pass + all.first_command + listed + sums[thread] - runs;
    if (is_there) list(bits, chunks[place], command);
    listed += sums[255];
    barrier();
  }
  if (thread != 0u) return;
  counts[pass * lists_of_pass + number] = listed;
  atomicAdd(triangles[triangles_place], indices / 3u);
}
)glsl";

}  // namespace lode::render
