#include "server/tiles/tile_content.h"

#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "common/codec/octahedral.h"
#include "common/codec/surface_normals.h"
#include "server/store/tile_encoder.h"

namespace lode::tiles {
namespace {

std::array<glm::vec3, 2> boundsOf(const Mesh& mesh, double step) {
  LatticeBox box;
  for (const PositionCode code : mesh.positions) box.add(unpackPosition(code));
  const auto factor = static_cast<float>(step);  // every product with `factor` is exact
  return {glm::vec3(box.min) * factor, glm::vec3(box.max) * factor};
}

/// Returns the octahedral code of each vertex's normal.
std::vector<uint16_t> normalsOf(const Mesh& mesh) {
  if (!mesh.attributes.has(AttributeSet::kNormal)) return surfaceNormals(mesh);
  std::vector<uint16_t> normals;
  normals.reserve(mesh.vertex_attributes.size());
  for (const VertexAttributes& vertex : mesh.vertex_attributes) normals.push_back(vertex.normal);
  return normals;
}

std::vector<std::byte> toSignedBytes(std::span<const uint16_t> normals) {
  std::vector<std::byte> bytes(normals.size() * kGlbNormalBytes);
  auto* to = bytes.data();
  for (const uint16_t code : normals) {
    const glm::vec3 normal = decodeOctahedral(code);
    for (int k = 0; k < 3; ++k) to[k] = static_cast<std::byte>(std::lround(127 * normal[k]));
    to += kGlbNormalBytes;
  }
  return bytes;
}

Mesh withNormals(const Mesh& mesh) {
  Mesh lit = mesh;
  if (mesh.attributes.has(AttributeSet::kNormal)) return lit;
  const std::vector<uint16_t> normals = normalsOf(mesh);
  lit.attributes.bits |= AttributeSet::kNormal;
  for (size_t v = 0; v < normals.size(); ++v) lit.vertex_attributes[v].normal = normals[v];
  return lit;
}

GlbPart encodedPart(const Mesh& mesh, double step, const GltfCoordinates* coordinates = nullptr) {
  return {encodeForGltf(mesh, step, coordinates), {}, mesh.triangles.size(), boundsOf(mesh, step), {}};
}

GlbImage insideImage(const Atlas& atlas) {
  const store::TileCodec codec = store::chooseCodec(atlas.image);
  return {.inside = store::encodeTile(atlas.image, codec, kImageQuality),
          .is_webp = codec != store::TileCodec::kJpeg,
          .cuts_out = atlas.is_clear};
}

}  // namespace

GlbContent plainContent(const store::DecodedLod& lod, double step) {
  if (lod.ids.colour) return {{encodedPart(withNormals(lod.mesh), step)}, {}};
  GlbPart part{{lod.payload, static_cast<uint32_t>(lod.mesh.positions.size()), lod.ids},
               {},
               lod.mesh.triangles.size(),
               boundsOf(lod.mesh, step),
               {}};
  if (!lod.ids.normal) part.normals = toSignedBytes(normalsOf(lod.mesh));
  return {{std::move(part)}, {}};
}

GlbContent texturedContent(const Mesh& mesh, const TextureSet& textures, double step, double error_model,
                           TextureLevels& levels, const std::function<std::string(SharedImage)>& uri_of) {
  const TexturedLod lod = textureLod(withNormals(mesh), textures, step, error_model, levels);
  GlbContent content;
  for (const TexturedPart& part : lod.parts) {
    const bool has_image = part.source != TexturedPart::Source::kNone;
    content.parts.push_back(encodedPart(part.mesh, step, has_image ? &part.coordinates : nullptr));
    if (!has_image) continue;
    content.parts.back().image = static_cast<uint32_t>(content.images.size());
    content.images.push_back(part.source == TexturedPart::Source::kAtlas
                                 ? insideImage(*lod.atlas)
                                 : GlbImage{.uri = uri_of(part.shared),
                                            .is_webp = !levels.isJpeg(part.shared.texture),
                                            .repeats = true,
                                            .cuts_out = levels.mayBeClear(part.shared.texture)});
  }
  return content;
}

}  // namespace lode::tiles
