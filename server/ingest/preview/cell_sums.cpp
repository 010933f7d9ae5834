#include "server/ingest/preview/cell_sums.h"

#include <cmath>

#include "common/codec/octahedral.h"

namespace lode::ingest {
namespace {

/// Weight of the cell's mean vertex, relative to the trace of the planes' quadric. The mean vertex makes the
/// minimum unique on flat surfaces.
constexpr double kMeanWeight = 1e-3;

AttributeSet withoutTextures(AttributeSet attributes, bool has_images) noexcept {
  if (has_images && attributes.has(AttributeSet::kTexture)) attributes.bits |= AttributeSet::kColour;
  attributes.bits &= AttributeSet::kNormal | AttributeSet::kColour | AttributeSet::kAlpha;
  if (!attributes.has(AttributeSet::kNormal))
    attributes.bits |= AttributeSet::kNormal | AttributeSet::kComputedNormal;
  return attributes;
}

}  // namespace

CellSums::CellSums(const PackedInput& input, const ClusterGrid& grid, const TextureColours& textures)
    : attributes_(withoutTextures(input.attributes(), !textures.empty())),
      has_vertex_normals_(input.ofVertices().has(AttributeSet::kNormal)),
      textures_(textures),
      sums_(grid.cellCount()) {
  if (!textures.empty() && input.ofVertices().has(AttributeSet::kTexture))
    texture_of_vertex_.resize(input.vertexCount());
  const bool has_colours = input.ofVertices().has(AttributeSet::kColour);
  input.readVertices(0, input.vertexCount(),
                     [&](uint64_t number, glm::dvec3, const VertexAttributes& attributes) {
                       const auto vertex = static_cast<uint32_t>(number);
                       if (!texture_of_vertex_.empty()) texture_of_vertex_[vertex] = attributes.texture;
                       Sum& sum = sums_[grid.cellOf(vertex)];
                       sum.point += glm::dvec3(grid.positionOf(vertex) - grid.cornerOf(grid.cellOf(vertex)));
                       ++sum.points;
                       if (has_vertex_normals_ && attributes.normal != kNoNormal)
                         sum.normal += glm::dvec3(decodeOctahedral(attributes.normal));
                       if (!has_colours) return;
                       sum.colour += glm::u64vec4(attributes.colour);
                       ++sum.colours;
                     });
}

void CellSums::addTriangle(const ClusterGrid& grid, glm::u32vec3 vertices, glm::u32vec3 cells,
                           const PackedInput::FaceBlock& block, const TrianglePlace& place) {
  const glm::dvec3 a = grid.positionOf(vertices.x), b = grid.positionOf(vertices.y),
                   c = grid.positionOf(vertices.z);
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double length = glm::length(normal);
  if (length == 0) return;
  addTexels(vertices, cells, block, place);
  for (int k = 0; k < 3; ++k) {
    if ((k > 0 && cells[k] == cells[0]) || (k == 2 && cells[2] == cells[1])) continue;
    Sum& sum = sums_[cells[k]];
    const glm::dvec3 from_corner = a - glm::dvec3(grid.cornerOf(cells[k]));
    sum.quadric.addPlane(normal, -glm::dot(normal, from_corner), 1 / length);
    if (!has_vertex_normals_) sum.normal += normal;
    if (block.colours.empty()) continue;
    sum.colour += glm::u64vec4(block.colours[place.face]);
    ++sum.colours;
  }
}

/// Adds the colours of the images at a triangle's corners.
void CellSums::addTexels(glm::u32vec3 vertices, glm::u32vec3 cells, const PackedInput::FaceBlock& block,
                         const TrianglePlace& place) {
  if (textures_.empty() || (block.texture.empty() && texture_of_vertex_.empty())) return;
  const uint16_t material = block.materials.empty() ? 0 : block.materials[place.face];
  for (int k = 0; k < 3; ++k) {
    const glm::u16vec2 texture =
        block.texture.empty() ? texture_of_vertex_[vertices[k]] : block.texture[place.corners[k]];
    Sum& sum = sums_[cells[k]];
    sum.texel += glm::u64vec3(textures_.at(material, texture));
    ++sum.texels;
  }
}

glm::uvec3 CellSums::pointOf(const ClusterGrid& grid, uint32_t cell) const {
  const Sum& sum = sums_[cell];
  const glm::dvec3 mean = sum.point / double(sum.points);
  Quadric quadric = sum.quadric;
  quadric.addPoint(mean, kMeanWeight * quadric.weight());
  const glm::dmat3 a(quadric.xx, quadric.xy, quadric.xz, quadric.xy, quadric.yy, quadric.yz, quadric.xz,
                     quadric.yz, quadric.zz);
  const glm::dvec3 best = -(glm::inverse(a) * quadric.b);
  const bool is_finite = std::isfinite(best.x) && std::isfinite(best.y) && std::isfinite(best.z);
  const glm::dvec3 inside =
      glm::clamp(glm::round(is_finite ? best : mean), 0.0, double(grid.widthSteps() - 1));
  return grid.cornerOf(cell) + glm::uvec3(inside);
}

VertexAttributes CellSums::attributesOf(uint32_t cell) const {
  const Sum& sum = sums_[cell];
  VertexAttributes attributes;
  const double length = glm::length(sum.normal);
  attributes.normal = encodeOctahedral(glm::vec3(length > 0 ? sum.normal / length : glm::dvec3(0)));
  if (sum.colours > 0)
    attributes.colour = glm::u8vec4((sum.colour + glm::u64vec4(sum.colours / 2)) / uint64_t{sum.colours});
  if (sum.texels > 0) {
    const glm::u64vec3 full = sum.texel * glm::u64vec3(attributes.colour);
    const uint64_t of_texels = uint64_t{sum.texels} * 255;
    attributes.colour = glm::u8vec4((full + of_texels / 2) / of_texels, attributes.colour.a);
  }
  if (!attributes_.has(AttributeSet::kAlpha)) attributes.colour.a = 255;
  return attributes;
}

}  // namespace lode::ingest
