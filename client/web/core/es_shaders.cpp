#include "client/web/core/es_shaders.h"

#include <string_view>

#include "client/render/passes/light.h"
#include "client/render/passes/mesh_shaders.h"

namespace lode::web {
namespace {

constexpr std::string_view kPrecision =
    "precision highp float;\nprecision highp int;\nprecision highp sampler2DArray;\n"
    "precision highp usampler2D;\n"
    "vec4 unpackUnorm4x8(uint word) {\n"
    "  return vec4(uvec4(word, word >> 8, word >> 16, word >> 24) & 255u) / 255.0;\n}\n";

/// Unpacks the layout of GpuTexturedVertex, and defines the attributes of the desktop client's shader.
constexpr std::string_view kVertexInput = R"glsl(
in uvec4 vertex_words;
#ifdef TEXTURED
in uvec2 texture_words;
#else
const uvec2 texture_words = uvec2(0u);
#endif
uniform uint draw_flags, draw_tint;
vec4 unpackNormal(uint word) {
  ivec3 codes = ivec3(int(word) << 22, int(word) << 12, int(word) << 2) >> 22;
  return vec4(max(vec3(codes) / 511.0, vec3(-1.0)), 0.0);
}
#define position_code vertex_words.xy
#define normal unpackNormal(vertex_words.z)
#define colour_srgb unpackUnorm4x8(vertex_words.w)
#define draw_state uvec3(draw_flags, draw_tint, 0x1000000u)
#define texture_code uvec3(texture_words.x & 0xffffu, texture_words.x >> 16, texture_words.y & 0xffffu)
#ifdef WIRE
out vec3 shares;
#endif
)glsl";

constexpr std::string_view kVertexEnd = R"glsl(
void main() {
  drawVertex();
#ifdef WIRE
  int corner = gl_VertexID % 3;
  shares = vec3(corner == 0, corner == 1, corner == 2);
#endif
  gl_Position.z = gl_Position.w - 2.0 * gl_Position.z;
}
)glsl";

constexpr std::string_view kTable = R"glsl(
uniform usampler2D tile_table;
uint tableAt(uint index) {
  return texelFetch(tile_table, ivec2(int(index & 1023u), int(index >> 10)), 0).x;
}
)glsl";

constexpr std::string_view kFragmentEnd = R"glsl(
void main() {
  drawPixel();
  vec3 light = clamp(pixel.rgb, 0.0, 1.0);
  pixel.rgb = mix(light * 12.92, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, greaterThan(light, vec3(0.0031308)));
}
)glsl";

void replaceAll(std::string& text, std::string_view from, std::string_view to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

/// Removes the lines that begin with a text.
void removeLines(std::string& text, std::string_view start) {
  for (size_t at = 0; (at = text.find(start, at)) != std::string::npos;)
    text.erase(at, text.find('\n', at) + 1 - at);
}

/// Removes the layout qualifiers, which ES 3.00 has for few variables only.
void removeLayouts(std::string& text) {
  for (size_t at = 0; (at = text.find("layout(", at)) != std::string::npos;)
    text.erase(at, text.find(") ", at) + 2 - at);
}

/// Turns "table[index]" into "tableAt(index)", also inside an index.
void replaceTable(std::string& text) {
  constexpr std::string_view kStart = "table[";
  for (size_t at = 0; (at = text.find(kStart, at)) != std::string::npos;) {
    size_t end = at + kStart.size();
    for (int depth = 1; depth > 0; ++end) depth += text[end] == '[' ? 1 : text[end] == ']' ? -1 : 0;
    text[end - 1] = ')';
    text.replace(at, kStart.size(), "tableAt(");
  }
}

/// Returns the variables of the macro CORNER as declarations. @param direction  "in" or "out".
std::string corner(std::string_view macro, std::string_view direction) {
  std::string lines, variables(macro.substr(std::string_view("CORNER ").size()));
  for (size_t at = 0, end = 0; (end = variables.find(';', at)) != std::string::npos; at = end + 1) {
    std::string_view variable = std::string_view(variables).substr(at, end - at);
    variable.remove_prefix(variable.find_first_not_of(' '));
    constexpr std::string_view kFlat = "flat ";
    const bool is_flat = variable.starts_with(kFlat);
    if (is_flat) variable.remove_prefix(kFlat.size());
    lines.append(is_flat ? "flat " : "").append(direction).append(" ").append(variable).append(";\n");
  }
  return lines;
}

std::string macros(const ShaderParts& parts) {
  std::string text;
  if (parts.textured) text += "#define TEXTURED\n";
  if (parts.cut_out) text += "#define CUT_OUT\n";
  if (parts.views) text += "#define VIEWS\n";
  if (parts.wire) text += "#define WIRE\n";
  return text.append(kPrecision);
}

}  // namespace

EsShaders esShaders(const ShaderParts& parts) {
  const std::string_view variables = parts.views ? render::kTintedCorner : render::kCorner;
  std::string vertex = render::kMeshVertexShader;
  for (int location = 0; location < 5; ++location)
    removeLines(vertex, "layout(location = " + std::to_string(location) + ") in ");
  removeLayouts(vertex);
  replaceAll(vertex, "out Corner { CORNER };", corner(variables, "out"));
  replaceAll(vertex, "void main()", "void drawVertex()");

  std::string fragment =
      std::string(render::kLightShader) + render::kWireShader + render::kMeshFragmentShader;
  removeLines(fragment, "layout(std430");
  removeLayouts(fragment);
  replaceAll(fragment, "in OfTriangle { CORNER };", corner(variables, "in"));
  replaceAll(fragment, "in Corner { CORNER };", corner(variables, "in"));
  replaceAll(fragment, "void main()", "void drawPixel()");
  replaceTable(fragment);
  std::string start = macros(parts);
  return {(start + std::string(kVertexInput) + vertex).append(kVertexEnd),
          (start + (parts.textured ? std::string(kTable) : "") + fragment).append(kFragmentEnd)};
}

}  // namespace lode::web
