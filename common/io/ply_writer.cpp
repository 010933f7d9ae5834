#include "common/io/ply_writer.h"

#include <span>
#include <string>

#include "common/codec/octahedral.h"
#include "common/codec/texture_set.h"
#include "common/io/atomic_file.h"
#include "common/io/little_endian_row.h"

namespace lode {
namespace {

bool fitsFloat(double value) { return static_cast<double>(static_cast<float>(value)) == value; }

bool fitFloats(const Mesh& mesh, const Lattice& lattice) {
  for (const PositionCode code : mesh.positions) {
    const glm::dvec3 p = lattice.toWorld(unpackPosition(code));
    if (!fitsFloat(p.x) || !fitsFloat(p.y) || !fitsFloat(p.z)) return false;
  }
  return true;
}

std::string headerOf(const Mesh& mesh, bool floats, const TextureSet& textures) {
  const std::string type = floats ? "property float " : "property double ";
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const Texture& texture : textures.textures) header += "comment TextureFile " + texture.name + "\n";
  header += "element vertex " + std::to_string(mesh.positions.size()) + "\n" + type + "x\n" + type + "y\n" +
            type + "z\n";
  if (mesh.attributes.has(AttributeSet::kNormal))
    header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (mesh.attributes.has(AttributeSet::kColour | AttributeSet::kAlpha))
    header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (mesh.attributes.has(AttributeSet::kAlpha)) header += "property uchar alpha\n";
  if (mesh.attributes.has(AttributeSet::kTexture)) header += "property float s\nproperty float t\n";
  header +=
      "element face " + std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\n";
  if (mesh.attributes.has(AttributeSet::kMaterial)) header += "property int texnumber\n";
  return header + "end_header\n";
}

void addAttributes(LittleEndianRow& row, AttributeSet set, const VertexAttributes& attributes,
                   const TextureSet& textures) {
  if (set.has(AttributeSet::kNormal)) {
    const glm::vec3 normal = decodeOctahedral(attributes.normal);
    for (int i = 0; i < 3; ++i) row.add(normal[i]);
  }
  if (set.has(AttributeSet::kColour | AttributeSet::kAlpha))
    for (int i = 0; i < (set.has(AttributeSet::kAlpha) ? 4 : 3); ++i) row.add(attributes.colour[i]);
  if (set.has(AttributeSet::kTexture)) {
    const glm::dvec2 uv = trueTextureCoordinates(textures, attributes);
    for (int i = 0; i < 2; ++i) row.add(static_cast<float>(uv[i]));
  }
}

void writeVertices(AtomicFile& file, const Mesh& mesh, const Lattice& lattice, bool floats,
                   const TextureSet& textures) {
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    LittleEndianRow row;
    const glm::dvec3 p = lattice.toWorld(unpackPosition(mesh.positions[i]));
    for (int axis = 0; axis < 3; ++axis) {
      if (floats)
        row.add(static_cast<float>(p[axis]));
      else
        row.add(p[axis]);
    }
    if (!mesh.vertex_attributes.empty())
      addAttributes(row, mesh.attributes, mesh.vertex_attributes[i], textures);
    file.write(row.bytes());
  }
}

int32_t texnumberOf(uint16_t material) { return material == kNoMaterial ? -1 : material; }

// Writes the faces. Takes a face's material from its first corner, because all corners of a triangle have the
// same material.
void writeFaces(AtomicFile& file, const Mesh& mesh) {
  for (const glm::u32vec3 triangle : mesh.triangles) {
    LittleEndianRow row;
    row.add(uint8_t{3});
    for (int corner = 0; corner < 3; ++corner) row.add(triangle[corner]);
    if (mesh.attributes.has(AttributeSet::kMaterial))
      row.add(texnumberOf(mesh.vertex_attributes[triangle.x].material));
    file.write(row.bytes());
  }
}

}  // namespace

void writePly(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
              const TextureSet& textures) {
  AtomicFile file(path);
  const bool floats = fitFloats(mesh, lattice);
  const std::string header = headerOf(mesh, floats, textures);
  file.write(std::as_bytes(std::span(header)));
  writeVertices(file, mesh, lattice, floats, textures);
  writeFaces(file, mesh);
  file.commit();
}

}  // namespace lode
