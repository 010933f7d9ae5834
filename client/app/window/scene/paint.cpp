#include "client/app/window/scene/paint.h"

#include <algorithm>

#include "common/image/image.h"

namespace lode::app {
namespace {

glm::dvec3 toLinear(const glm::u8vec4& srgb) {
  return {linearOf(srgb.r), linearOf(srgb.g), linearOf(srgb.b)};
}

/// Returns the texel at a texture coordinate, from the finest resident level of a texture. @param uv  v = 0
/// is the bottom edge of the image.
std::optional<glm::u8vec4> texelAt(const core::Cut& cut, uint32_t number, const glm::dvec2& uv) {
  if (!cut.textures || number >= cut.textures->textures.size()) return std::nullopt;
  const Texture& texture = cut.textures->textures[number];
  const glm::dvec2 at = glm::fract(glm::dvec2(uv.x, 1 - uv.y));
  for (uint32_t level = 0; level < levelCount(texture); ++level) {
    const glm::uvec2 size = levelSize(texture, level);
    const glm::uvec2 texel = glm::min(glm::uvec2(at * glm::dvec2(size)), size - 1u);
    const glm::uvec2 tile = texel / kTileInnerPx;
    const core::TileKey key{level, number, tile.y, tile.x};
    const auto found = std::ranges::lower_bound(cut.tiles, key, {}, &core::ResidentTile::key);
    if (found == cut.tiles.end() || found->key != key) continue;
    const glm::uvec2 in_tile = texel - tile * kTileInnerPx + kTileGutterPx;
    return found->image->texels[size_t{in_tile.y} * found->image->size.x + in_tile.x];
  }
  return std::nullopt;
}

}  // namespace

std::optional<glm::u8vec3> paintAt(const core::Hit& hit, const core::Cut& textured) {
  const Mesh& mesh = *hit.part->mesh;
  if (mesh.vertex_attributes.empty()) return std::nullopt;
  const bool has_colours = mesh.attributes.has(AttributeSet::kColour);
  glm::dvec3 light(0);
  glm::dvec2 code(0);
  const glm::u32vec3& corners = mesh.triangles[hit.triangle];
  for (int k = 0; k < 3; ++k) {
    const VertexAttributes& vertex = mesh.vertex_attributes[corners[k]];
    light += hit.weights[k] * toLinear(vertex.colour);
    code += hit.weights[k] * glm::dvec2(vertex.texture);
  }
  std::optional<glm::u8vec4> texel;
  if (textured.textures && mesh.attributes.has(AttributeSet::kTexture))
    texel = texelAt(textured, mesh.vertex_attributes[corners[0]].material,
                    textured.textures->uv_origin + code * uvStep(*textured.textures));
  if (!texel && !has_colours) return std::nullopt;
  if (texel) light = has_colours ? light * toLinear(*texel) : toLinear(*texel);
  return glm::u8vec3(srgbOf(light.r), srgbOf(light.g), srgbOf(light.b));
}

}  // namespace lode::app
