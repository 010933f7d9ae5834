#include "common/io/glb_writer.h"

#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/codec/octahedral.h"
#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/image/image.h"
#include "common/io/atomic_file.h"
#include "common/io/little_endian_row.h"
#include "common/io/mesh_materials.h"

namespace lode {
namespace {

using Json = nlohmann::ordered_json;

// Constants of the glTF specification.
constexpr uint32_t kMagic = 0x46546c67, kGlbVersion = 2, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kVertexBuffer = 34962, kIndexBuffer = 34963;
constexpr uint64_t kHeaderBytes = 12, kChunkHeaderBytes = 8;

/// Smallest and largest lattice step for which all positions are exact floats, each with a margin.
constexpr double kLeastStep = 0x1p-120, kLargestStep = 0x1p100;

/// Converts an sRGB byte to linear light, 0 to 65535.
uint16_t toLinear(uint8_t byte) { return static_cast<uint16_t>(std::lround(65535 * linearOf(byte))); }

/// Converts a file name to a relative reference (RFC 3986).
std::string toUri(const std::string& name) {
  constexpr std::string_view kHexadecimal = "0123456789ABCDEF";
  std::string uri;
  for (const char c : name) {
    const auto byte = static_cast<uint8_t>(c);
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("-._~/").find(c) != std::string_view::npos;
    if (plain)
      uri += c;
    else
      (((uri += '%') += kHexadecimal[byte >> 4]) += kHexadecimal[byte & 15]);
  }
  return uri;
}

/// Describes the parts of the binary chunk. The caller must write the parts in the order in which it adds
/// them here.
class Parts {
 public:
  /// Adds a part. @return the index of the part's accessor.
  size_t add(const char* type, int component, uint64_t count, uint64_t element_bytes, int target) {
    views_.push_back(
        {{"buffer", 0}, {"byteOffset", bytes_}, {"byteLength", count * element_bytes}, {"target", target}});
    accessors_.push_back(
        {{"bufferView", views_.size() - 1}, {"componentType", component}, {"count", count}, {"type", type}});
    bytes_ += count * element_bytes;
    return accessors_.size() - 1;
  }
  Json& accessor(size_t number) { return accessors_[number]; }
  uint64_t bytes() const noexcept { return bytes_; }

  void describe(Json& document) {
    document["accessors"] = std::move(accessors_);
    document["bufferViews"] = std::move(views_);
    document["buffers"][0]["byteLength"] = bytes_;
  }

 private:
  Json views_ = Json::array(), accessors_ = Json::array();
  uint64_t bytes_ = 0;
};

glm::vec3 positionOf(PositionCode code, const Lattice& lattice) {
  return glm::vec3(glm::dvec3(unpackPosition(code)) * lattice.step);
}

/// Adds the arrays of vertices. @return the index of each attribute's accessor.
Json addVertices(Parts& parts, const Mesh& mesh, const Lattice& lattice) {
  const uint64_t count = mesh.positions.size();
  Json attributes;
  const size_t positions = parts.add("VEC3", kFloat, count, 12, kVertexBuffer);
  glm::vec3 min(std::numeric_limits<float>::max()), max(std::numeric_limits<float>::lowest());
  for (const PositionCode code : mesh.positions) {
    const glm::vec3 p = positionOf(code, lattice);
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
  parts.accessor(positions)["min"] = {min.x, min.y, min.z};
  parts.accessor(positions)["max"] = {max.x, max.y, max.z};
  attributes["POSITION"] = positions;
  if (mesh.attributes.has(AttributeSet::kNormal))
    attributes["NORMAL"] = parts.add("VEC3", kFloat, count, 12, kVertexBuffer);
  if (mesh.attributes.has(AttributeSet::kColour | AttributeSet::kAlpha)) {
    const size_t colours = parts.add("VEC4", kUnsignedShort, count, 8, kVertexBuffer);
    parts.accessor(colours)["normalized"] = true;
    attributes["COLOR_0"] = colours;
  }
  if (mesh.attributes.has(AttributeSet::kTexture))
    attributes["TEXCOORD_0"] = parts.add("VEC2", kFloat, count, 8, kVertexBuffer);
  return attributes;
}

/// Returns true if the mesh has a usable alpha channel. A channel that is 0 at all vertices was never filled,
/// and a viewer that used it would show nothing.
bool hasAlpha(const Mesh& mesh) {
  return mesh.attributes.has(AttributeSet::kAlpha) &&
         std::ranges::any_of(mesh.vertex_attributes,
                             [](const VertexAttributes& vertex) { return vertex.colour.a != 0; });
}

/// Returns true if a vertex of the group is not opaque.
bool hasTransparency(const Mesh& mesh, const MaterialGroup& group) {
  const auto isClear = [&](uint32_t vertex) { return mesh.vertex_attributes[vertex].colour.a != 255; };
  return std::ranges::any_of(group.triangles, [&](uint32_t number) {
    const glm::u32vec3 triangle = mesh.triangles[number];
    return isClear(triangle.x) || isClear(triangle.y) || isClear(triangle.z);
  });
}

/// Adds a matt, double-sided material.
/// @param image  file name of the material's image, or empty.
/// @param alpha_mode  alphaMode of the specification; empty for the default, which ignores alpha.
void addMaterial(Json& document, const std::string& image, const std::string& alpha_mode) {
  Json surface{{"metallicFactor", 0}, {"roughnessFactor", 1}};
  if (!image.empty()) {
    document["images"].push_back({{"uri", toUri(image)}});
    document["textures"].push_back({{"source", document["images"].size() - 1}});
    surface["baseColorTexture"] = {{"index", document["textures"].size() - 1}};
  }
  Json material{{"pbrMetallicRoughness", surface}, {"doubleSided", true}};
  if (!alpha_mode.empty()) material["alphaMode"] = alpha_mode;
  document["materials"].push_back(material);
}

Json describe(const Mesh& mesh, const Lattice& lattice, const ImageFiles& images,
              const std::vector<MaterialGroup>& groups, Parts& parts) {
  Json document;
  document["asset"] = {{"version", "2.0"}, {"generator", "Lodestream"}};
  document["scene"] = 0;
  if (groups.empty()) {  // glTF allows an empty scene but no empty mesh
    document["scenes"] = Json::array({Json::object()});
    return document;
  }
  document["scenes"][0]["nodes"][0] = 0;
  Json& node = document["nodes"][0];
  node["mesh"] = 0;
  node["translation"] = {lattice.origin.x, lattice.origin.y, lattice.origin.z};
  const Json attributes = addVertices(parts, mesh, lattice);
  Json primitives = Json::array();
  const bool has_alpha = hasAlpha(mesh);
  for (const MaterialGroup& group : groups) {
    const size_t indices =
        parts.add("SCALAR", kUnsignedInt, 3 * uint64_t{group.triangles.size()}, 4, kIndexBuffer);
    primitives.push_back({{"attributes", attributes}, {"indices", indices}, {"material", primitives.size()}});
    const std::string image = imageOf(mesh, images.set, group.material);
    const bool cuts_out = !image.empty() && cutsOut(images, group.material);
    addMaterial(document, image,
                has_alpha && hasTransparency(mesh, group) ? "BLEND"
                : cuts_out                                ? "MASK"
                                                          : "");
  }
  document["meshes"][0]["primitives"] = std::move(primitives);
  parts.describe(document);
  return document;
}

template <typename Vector>
void writeNumbers(AtomicFile& file, const Vector& numbers) {
  LittleEndianRow row;
  for (int i = 0; i < Vector::length(); ++i) row.add(numbers[i]);
  file.write(row.bytes());
}

void writeVertices(AtomicFile& file, const Mesh& mesh, const Lattice& lattice, const TextureSet& textures) {
  for (const PositionCode code : mesh.positions) writeNumbers(file, positionOf(code, lattice));
  if (mesh.attributes.has(AttributeSet::kNormal))
    for (const VertexAttributes& vertex : mesh.vertex_attributes)
      writeNumbers(file, decodeOctahedral(vertex.normal));
  if (mesh.attributes.has(AttributeSet::kColour | AttributeSet::kAlpha)) {
    std::array<uint16_t, 256> linear{};
    for (size_t byte = 0; byte < linear.size(); ++byte) linear[byte] = toLinear(static_cast<uint8_t>(byte));
    const bool has_alpha = hasAlpha(mesh);
    for (const VertexAttributes& vertex : mesh.vertex_attributes) {
      const glm::u8vec4 c = vertex.colour;
      writeNumbers(file, glm::u16vec4(linear[c.r], linear[c.g], linear[c.b], has_alpha ? c.a * 257 : 65535));
    }
  }
  if (mesh.attributes.has(AttributeSet::kTexture))
    for (const VertexAttributes& vertex : mesh.vertex_attributes) {
      const glm::dvec2 uv = trueTextureCoordinates(textures, vertex);
      writeNumbers(file, glm::vec2(uv.x, 1 - uv.y));  // in glTF v is 0 at the top of the image
    }
}

}  // namespace

void writeGlb(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
              const ImageFiles& images) {
  if (!(lattice.step >= kLeastStep && lattice.step <= kLargestStep))
    throw Error(ErrorCode::kLimit,
                path.string() + ": its coordinates are too small or too large for glTF; write PLY");
  const std::vector<MaterialGroup> groups = groupByMaterial(mesh);
  Parts parts;
  std::string text = describe(mesh, lattice, images, groups, parts).dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const uint64_t binary_bytes = parts.bytes() == 0 ? 0 : kChunkHeaderBytes + parts.bytes();
  const uint64_t bytes = kHeaderBytes + kChunkHeaderBytes + text.size() + binary_bytes;
  if (bytes > std::numeric_limits<uint32_t>::max())
    throw Error(ErrorCode::kLimit, path.string() +
                                       ": a GLB file can have at most 4 GB, but this file would have " +
                                       std::to_string(bytes) + " bytes: write PLY, or ask for a coarser cut");
  AtomicFile file(path);
  const auto writeHeader = [&file](auto... numbers) {
    LittleEndianRow row;
    (row.add(static_cast<uint32_t>(numbers)), ...);
    file.write(row.bytes());
  };
  writeHeader(kMagic, kGlbVersion, bytes);
  writeHeader(text.size(), kJsonChunk);
  file.write(std::as_bytes(std::span(text)));
  if (binary_bytes != 0) {
    writeHeader(parts.bytes(), kBinaryChunk);
    writeVertices(file, mesh, lattice, images.set);
    for (const MaterialGroup& group : groups)
      for (const uint32_t number : group.triangles) writeNumbers(file, mesh.triangles[number]);
  }
  file.commit();
}

}  // namespace lode
