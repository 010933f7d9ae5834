#include "common/io/obj_writer.h"

#include <array>
#include <charconv>
#include <span>
#include <string>
#include <string_view>

#include "common/codec/octahedral.h"
#include "common/codec/texture_set.h"
#include "common/io/atomic_file.h"
#include "common/io/mesh_materials.h"

namespace lode {
namespace {

/// Writes lines of words and numbers, separated by spaces.
class TextFile {
 public:
  TextFile(const std::filesystem::path& path, OutputName name) : file_(path, {}, name) {}

  TextFile& word(std::string_view text) {
    if (!line_.empty()) line_ += ' ';
    line_ += text;
    return *this;
  }
  /// Adds the shortest text without an exponent that reads back as exactly this number.
  template <typename Number>
  TextFile& number(Number value) {
    std::array<char, 512> text{};
    const auto end =
        std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed).ptr;
    return word({text.data(), static_cast<size_t>(end - text.data())});
  }
  void endLine() {
    line_ += '\n';
    file_.write(std::as_bytes(std::span(line_)));
    line_.clear();
  }
  void commit() { file_.commit(); }

 private:
  AtomicFile file_;
  std::string line_;
};

std::string materialName(uint16_t material) {
  return "material_" + (material == kNoMaterial ? "none" : std::to_string(material));
}

void writeVertices(TextFile& file, const Mesh& mesh, const Lattice& lattice, const TextureSet& textures) {
  const bool coloured = mesh.attributes.has(AttributeSet::kColour | AttributeSet::kAlpha);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::dvec3 p = lattice.toWorld(unpackPosition(mesh.positions[i]));
    file.word("v").number(p.x).number(p.y).number(p.z);
    if (coloured)
      for (int channel = 0; channel < 3; ++channel)
        file.number(static_cast<float>(mesh.vertex_attributes[i].colour[channel]) / 255);
    file.endLine();
  }
  if (mesh.attributes.has(AttributeSet::kTexture))
    for (const VertexAttributes& vertex : mesh.vertex_attributes) {
      const glm::vec2 uv = trueTextureCoordinates(textures, vertex);
      file.word("vt").number(uv.x).number(uv.y).endLine();
    }
  if (mesh.attributes.has(AttributeSet::kNormal))
    for (const VertexAttributes& vertex : mesh.vertex_attributes) {
      const glm::vec3 normal = decodeOctahedral(vertex.normal);
      file.word("vn").number(normal.x).number(normal.y).number(normal.z).endLine();
    }
}

/// Returns one corner of a face: v, v/vt, v//vn or v/vt/vn. All of these are the vertex's number, counted
/// from 1.
std::string corner(uint32_t vertex, AttributeSet attributes) {
  const std::string number = std::to_string(uint64_t{vertex} + 1);
  std::string text = number;
  if (attributes.has(AttributeSet::kTexture)) text += "/" + number;
  if (attributes.has(AttributeSet::kNormal))
    text += (attributes.has(AttributeSet::kTexture) ? "/" : "//") + number;
  return text;
}

/// Writes the material file. @return false, without writing a file, if no material has an image.
bool writeMaterials(const std::filesystem::path& path, const Mesh& mesh, const ImageFiles& images,
                    const std::vector<MaterialGroup>& groups) {
  bool any = false;
  for (const MaterialGroup& group : groups) any |= !imageOf(mesh, images.set, group.material).empty();
  if (!any) return false;
  TextFile file(path, OutputName::kDerived);
  for (const MaterialGroup& group : groups) {
    file.word("newmtl").word(materialName(group.material)).endLine();
    file.word("Kd 1 1 1").endLine();
    const std::string image = imageOf(mesh, images.set, group.material);
    if (!image.empty()) file.word("map_Kd").word(image).endLine();
    if (!image.empty() && cutsOut(images, group.material)) file.word("map_d").word(image).endLine();
  }
  file.commit();
  return true;
}

}  // namespace

std::filesystem::path materialFileOf(const std::filesystem::path& obj) {
  return std::filesystem::path(obj).replace_extension(".mtl");
}

bool writeObj(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
              const ImageFiles& images) {
  const std::vector<MaterialGroup> groups = groupByMaterial(mesh);
  const std::filesystem::path materials = materialFileOf(path);
  TextFile file(path, OutputName::kTyped);
  const bool has_materials = writeMaterials(materials, mesh, images, groups);
  if (has_materials) file.word("mtllib").word(materials.filename().string()).endLine();
  writeVertices(file, mesh, lattice, images.set);
  for (const MaterialGroup& group : groups) {
    if (has_materials) file.word("usemtl").word(materialName(group.material)).endLine();
    for (const uint32_t number : group.triangles) {
      file.word("f");
      for (int i = 0; i < 3; ++i) file.word(corner(mesh.triangles[number][i], mesh.attributes));
      file.endLine();
    }
  }
  file.commit();
  return has_materials;
}

}  // namespace lode
