#include "client/render/passes/shaders.h"

namespace lode::render {

const char* const kWireGeometryShader = R"glsl(
layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;

in Corner { CORNER } corner[];
out OfTriangle { CORNER };
out vec3 shares;  // of the triangle's corners in the pixel

void main() {
  for (int i = 0; i < 3; ++i) {
    gl_Position = gl_in[i].gl_Position;
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

const float kLinePx = 1.1;
const float kCrowdedPx = 3.0, kRoomyPx = 8.0;  // sizes of triangles
const float kCrowded = 0.55, kBetween = 0.25;

/// How bright the pixel is: bright lines before what lies dim between. Where triangles are so small that lines
/// would leave nothing between them, they fade into the surface.
float wire() {
  vec3 across = dFdx(shares), down = dFdy(shares);
  vec3 heights_px = inversesqrt(max(across * across + down * down, 1e-12));
  float area = 0.5 / max(length(cross(across, down)), 1e-12) * 1.7320508;
  float room = smoothstep(kCrowdedPx, kRoomyPx, sqrt(area));
  vec3 from_edges_px = shares * heights_px;
  float nearest_px = min(min(from_edges_px.x, from_edges_px.y), from_edges_px.z);
  float line = clamp(kLinePx - nearest_px, 0.0, 1.0);
  return mix(kCrowded, mix(kBetween, 1.0, line), room);
}
#endif
)glsl";

}  // namespace lode::render
