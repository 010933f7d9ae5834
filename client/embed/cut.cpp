#include "client/core/lod/cut.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "client/core/view/camera_path.h"
#include "client/embed/internal.h"
#include "client/embed/lodestream.h"
#include "common/codec/octahedral.h"
#include "common/codec/texture_set.h"
#include "common/error.h"

struct lodestream_mesh {
  std::vector<float> positions, normals, texture_uvs;
  std::vector<uint8_t> colours;
  std::vector<uint16_t> texture_of;
  std::vector<uint32_t> indices;
};

namespace lode::embed {
namespace {

void checkNumber(size_t number, size_t count, const char* what) {
  if (number >= count)
    throw Error(ErrorCode::kUsage, "number " + std::to_string(number) + " is out of range: the cut has " +
                                       std::to_string(count) + " " + what);
}

template <typename Things>
const auto& at(const Things& things, size_t number, const char* what) {
  checkNumber(number, things.size(), what);
  return things[number];
}

const core::CutPart& partAt(const core::Cut& cut, size_t number) {
  checkNumber(number, partCount(cut), "parts and fallbacks");
  return partOf(cut, number);
}

template <typename Value>
const Value* dataOrNull(const std::vector<Value>& values) {
  return values.empty() ? nullptr : values.data();
}

const core::Cut& cutAt(const lodestream_cut* cut) {
  return *given(cut, "cut", "one from lodestream_take_cut()").cut;
}

/// Returns the id of a part's mesh. The id changes when the texture set is loaded, because the mesh then gets
/// texture coordinates.
uint64_t meshId(const core::Cut& cut, const core::CutPart& part) {
  static_assert(alignof(Mesh) > 1);
  return reinterpret_cast<uintptr_t>(part.mesh.get()) | (cut.textures ? 1 : 0);
}

uint16_t textureOf(const VertexAttributes& vertex, const TextureSet& textures) {
  static_assert(LODESTREAM_NO_TEXTURE == kNoMaterial);
  return vertex.material < textures.textures.size() ? vertex.material : kNoMaterial;
}

void addAttributes(lodestream_mesh& out, const Mesh& mesh, const TextureSet* textures) {
  const bool has_normals = mesh.attributes.has(AttributeSet::kNormal | AttributeSet::kComputedNormal);
  const bool has_texture = textures != nullptr && mesh.attributes.has(AttributeSet::kTexture);
  for (const VertexAttributes& vertex : mesh.vertex_attributes) {
    if (has_normals) {
      const glm::vec3 normal = decodeOctahedral(vertex.normal);
      out.normals.insert(out.normals.end(), {normal.x, normal.y, normal.z});
    }
    if (mesh.attributes.has(AttributeSet::kColour))
      out.colours.insert(out.colours.end(),
                         {vertex.colour.r, vertex.colour.g, vertex.colour.b, vertex.colour.a});
    if (!has_texture) continue;
    const glm::dvec2 uv = trueTextureCoordinates(*textures, vertex);
    out.texture_uvs.insert(out.texture_uvs.end(), {static_cast<float>(uv.x), static_cast<float>(uv.y)});
    if (!textures->textures.empty()) out.texture_of.push_back(textureOf(vertex, *textures));
  }
}

std::unique_ptr<lodestream_mesh> flatten(const Mesh& mesh, double lattice_step, const TextureSet* textures) {
  auto out = std::make_unique<lodestream_mesh>();
  const auto step = static_cast<float>(lattice_step);
  out->positions.reserve(3 * mesh.positions.size());
  for (const PositionCode code : mesh.positions) {
    const glm::vec3 position = glm::vec3(unpackPosition(code)) * step;
    out->positions.insert(out->positions.end(), {position.x, position.y, position.z});
  }
  addAttributes(*out, mesh, textures);
  out->indices.reserve(3 * mesh.triangles.size());
  for (const glm::u32vec3& triangle : mesh.triangles)
    out->indices.insert(out->indices.end(), {triangle.x, triangle.y, triangle.z});
  return out;
}

lodestream_arrays arraysOf(const lodestream_mesh& mesh) {
  lodestream_arrays arrays{};
  arrays.vertices = static_cast<uint32_t>(mesh.positions.size() / 3);
  arrays.triangles = static_cast<uint32_t>(mesh.indices.size() / 3);
  arrays.positions = dataOrNull(mesh.positions);
  arrays.normals = dataOrNull(mesh.normals);
  arrays.colours = dataOrNull(mesh.colours);
  arrays.texture_uvs = dataOrNull(mesh.texture_uvs);
  arrays.texture_of = dataOrNull(mesh.texture_of);
  arrays.indices = dataOrNull(mesh.indices);
  return arrays;
}

glm::dvec3 toVector(const double (&values)[3]) { return {values[0], values[1], values[2]}; }

}  // namespace

core::View toView(const lodestream_view& view, const ModelSummary& model) {
  const auto isFinite = [](const double(&values)[3]) {
    return std::all_of(std::begin(values), std::end(values),
                       [](double value) { return std::isfinite(value); });
  };
  const bool has_size = std::clamp(view.width_px, 1u, core::kMaxPictureSidePx) == view.width_px &&
                        std::clamp(view.height_px, 1u, core::kMaxPictureSidePx) == view.height_px;
  if (!isFinite(view.eye) || !isFinite(view.target) || !isFinite(view.up) || !has_size ||
      !(view.fov_y_deg >= core::kMinFovDeg && view.fov_y_deg <= core::kMaxFovDeg) || !(view.threshold_px > 0))
    throw Error(ErrorCode::kUsage,
                "invalid view: it needs finite vectors, a picture of 1 to 32768 pixels each way, fov_y_deg "
                "from 0.01 to "
                "170 and a threshold above 0; set no view while a window has no pixels");
  const core::CameraKey camera{0, toVector(view.eye), toVector(view.target), toVector(view.up)};
  return core::toView(camera, view.fov_y_deg, view.width_px, view.height_px, model);
}

}  // namespace lode::embed

using lode::embed::at;
using lode::embed::guard;

void lodestream_release_cut(lodestream_cut* cut) { const std::unique_ptr<lodestream_cut> released(cut); }

void lodestream_cut_describe(const lodestream_cut* cut, lodestream_cut_info* info) {
  if (info == nullptr) return;
  *info = {};
  if (cut == nullptr) return;
  const lode::core::Cut& of = *cut->cut;
  info->parts = of.parts.size();
  info->fallbacks = of.fallbacks.size();
  info->tiles = of.tiles.size();
  info->textures = of.textures ? of.textures->textures.size() : 0;
  info->triangles = of.triangles;
  info->max_error_px = of.max_error_px;
  info->is_converged = lode::embed::isWithin(of, of.threshold_px);
  info->is_finest = lode::embed::isFinest(of);
  info->serial = cut->serial;
}

int lodestream_cut_part(const lodestream_cut* cut, size_t number, lodestream_part* part) {
  return guard([&] {
    const lode::core::Cut& whole = lode::embed::cutAt(cut);
    const lode::core::CutPart& of = lode::embed::partAt(whole, number);
    lode::embed::given(part, "part") = {lode::embed::meshId(whole, of), of.node.value, of.lod, of.visible,
                                        of.mesh->triangles.size(),      of.error_px};
  });
}

int lodestream_cut_shown(const lodestream_cut* cut, const lodestream_view* view, size_t* numbers,
                         size_t* count) {
  return guard([&] {
    const lode::core::Cut& of = lode::embed::cutAt(cut);
    lode::embed::given(count, "count") = 0;
    const lode::core::View seen = lode::embed::toView(lode::embed::given(view, "view"), cut->model);
    const std::vector<uint32_t> shown = shownParts(of, seen);
    if (!shown.empty()) std::copy(shown.begin(), shown.end(), &lode::embed::given(numbers, "array"));
    *count = shown.size();
  });
}

lodestream_mesh* lodestream_take_mesh(const lodestream_cut* cut, size_t part, lodestream_arrays* arrays) {
  lodestream_mesh* mesh = nullptr;
  guard([&] {
    const lode::core::Cut& whole = lode::embed::cutAt(cut);
    const lode::Mesh& of = *lode::embed::partAt(whole, part).mesh;
    lode::embed::given(arrays, "struct of arrays");
    mesh = lode::embed::flatten(of, cut->model.lattice.step, whole.textures.get()).release();
    *arrays = lode::embed::arraysOf(*mesh);
  });
  return mesh;
}

void lodestream_release_mesh(lodestream_mesh* mesh) { const std::unique_ptr<lodestream_mesh> released(mesh); }

int lodestream_cut_tile(const lodestream_cut* cut, size_t number, lodestream_tile* tile) {
  return guard([&] {
    const lode::core::ResidentTile& of = at(lode::embed::cutAt(cut).tiles, number, "tiles");
    lode::embed::given(tile, "tile") = {of.key.texture,
                                        of.key.level,
                                        of.key.x,
                                        of.key.y,
                                        of.image->size.x,
                                        of.image->size.y,
                                        reinterpret_cast<const uint8_t*>(of.image->texels.data())};
  });
}

int lodestream_cut_texture(const lodestream_cut* cut, size_t number, lodestream_texture* texture) {
  return guard([&] {
    static const std::vector<lode::Texture> none;
    const lode::core::Cut& whole = lode::embed::cutAt(cut);
    const auto& textures = whole.textures ? whole.textures->textures : none;
    const lode::Texture& of = at(textures, number, "textures");
    lode::embed::given(texture, "texture") = {of.width, of.height, levelCount(of)};
  });
}
