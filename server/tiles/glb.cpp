#include "server/tiles/glb.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/codec/octahedral.h"
#include "common/codec/surface_normals.h"
#include "common/io/little_endian_row.h"

namespace lode::tiles {
namespace {

using Json = nlohmann::ordered_json;

// Constants of the glTF specification.
constexpr uint32_t kMagic = 0x46546c67, kGlbVersion = 2, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;
constexpr int kByte = 5120, kUnsignedInt = 5125, kFloat = 5126, kVertexBuffer = 34962;
constexpr uint32_t kHeaderBytes = 12, kChunkHeaderBytes = 8;

/// Bytes of a normal: three signed bytes and one unused byte, because glTF aligns vertices to four bytes.
constexpr size_t kNormalBytes = 4;

/// The parts of a GLB whose bytes are known.
struct Content {
  GltfStream stream;
  std::vector<std::byte> normals;  ///< normals outside the stream, kNormalBytes per vertex; may be empty
  uint64_t triangles = 0;
  std::array<glm::vec3, 2> bounds;  ///< least and greatest coordinates of the positions
};

uint32_t padded(size_t bytes) { return static_cast<uint32_t>((bytes + 3) / 4 * 4); }

std::array<glm::vec3, 2> boundsOf(const Mesh& mesh, double step) {
  LatticeBox box;
  for (const PositionCode code : mesh.positions) box.add(unpackPosition(code));
  const auto factor = static_cast<float>(step);  // the products are exact
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
  std::vector<std::byte> bytes(normals.size() * kNormalBytes);
  auto* to = bytes.data();
  for (const uint16_t code : normals) {
    const glm::vec3 normal = decodeOctahedral(code);
    for (int k = 0; k < 3; ++k) to[k] = static_cast<std::byte>(std::lround(127 * normal[k]));
    to += kNormalBytes;
  }
  return bytes;
}

GltfStream withLinearColours(const Mesh& mesh, double step) {
  if (mesh.attributes.has(AttributeSet::kNormal)) return encodeForGltf(mesh, step);
  Mesh lit = mesh;
  const std::vector<uint16_t> normals = normalsOf(mesh);
  lit.attributes.bits |= AttributeSet::kNormal;
  for (size_t v = 0; v < normals.size(); ++v) lit.vertex_attributes[v].normal = normals[v];
  return encodeForGltf(lit, step);
}

Content contentOf(const store::DecodedLod& lod, double step) {
  Content content{{}, {}, lod.mesh.triangles.size(), boundsOf(lod.mesh, step)};
  if (lod.ids.colour) {
    content.stream = withLinearColours(lod.mesh, step);
    return content;
  }
  content.stream = {lod.payload, static_cast<uint32_t>(lod.mesh.positions.size()), lod.ids};
  if (!lod.ids.normal) content.normals = toSignedBytes(normalsOf(lod.mesh));
  return content;
}

/// Describes the mesh of a GLB, one accessor and one attribute after the other.
class Description {
 public:
  explicit Description(const Content& content) : content_(content) {}

  Json make() {
    addAttribute("POSITION", "VEC3", content_.stream.ids.position);
    const auto& [least, most] = content_.bounds;
    accessors_[0]["min"] = {least.x, least.y, least.z};
    accessors_[0]["max"] = {most.x, most.y, most.z};
    if (content_.stream.ids.normal) addAttribute("NORMAL", "VEC3", *content_.stream.ids.normal);
    if (const auto colour = content_.stream.ids.colour)
      addAttribute("COLOR_0", content_.stream.ids.colour_components == 4 ? "VEC4" : "VEC3", *colour);
    if (!content_.normals.empty()) addNormalsBesideStream();
    accessors_.push_back(
        {{"componentType", kUnsignedInt}, {"count", 3 * content_.triangles}, {"type", "SCALAR"}});
    return document();
  }

 private:
  void addAttribute(const char* name, const char* type, uint32_t id) {
    attributes_[name] = accessors_.size();
    in_stream_[name] = id;
    accessors_.push_back({{"componentType", kFloat}, {"count", content_.stream.vertices}, {"type", type}});
  }

  void addNormalsBesideStream() {
    attributes_["NORMAL"] = accessors_.size();
    accessors_.push_back({{"bufferView", 1},
                          {"componentType", kByte},
                          {"normalized", true},
                          {"count", content_.stream.vertices},
                          {"type", "VEC3"}});
  }

  Json views() const {
    Json views = Json::array();
    views.push_back({{"buffer", 0}, {"byteLength", content_.stream.bytes.size()}});
    if (!content_.normals.empty())
      views.push_back({{"buffer", 0},
                       {"byteOffset", padded(content_.stream.bytes.size())},
                       {"byteLength", content_.normals.size()},
                       {"byteStride", kNormalBytes},
                       {"target", kVertexBuffer}});
    return views;
  }

  Json document() {
    Json extensions = Json::array({"KHR_draco_mesh_compression"});
    if (!content_.normals.empty()) extensions.push_back("KHR_mesh_quantization");
    Json material{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                  {"doubleSided", true}};
    Json primitive{
        {"attributes", std::move(attributes_)},
        {"indices", accessors_.size() - 1},
        {"material", 0},
        {"extensions",
         {{"KHR_draco_mesh_compression", {{"bufferView", 0}, {"attributes", std::move(in_stream_)}}}}}};
    Json document;
    document["asset"] = {{"version", "2.0"}, {"generator", "Lodestream"}};
    document["extensionsUsed"] = extensions;
    document["extensionsRequired"] = std::move(extensions);
    document["scene"] = 0;
    document["scenes"][0]["nodes"][0] = 0;
    document["nodes"][0] = {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1}}};
    document["meshes"][0]["primitives"][0] = std::move(primitive);
    document["materials"][0] = std::move(material);
    document["accessors"] = std::move(accessors_);
    document["bufferViews"] = views();
    document["buffers"][0]["byteLength"] = padded(content_.stream.bytes.size()) + content_.normals.size();
    return document;
  }

  const Content& content_;
  Json attributes_ = Json::object(), in_stream_ = Json::object(), accessors_ = Json::array();
};

/// Joins the chunks of a GLB.
class Chunks {
 public:
  explicit Chunks(size_t bytes) { bytes_.reserve(bytes); }
  void addNumbers(auto... numbers) {
    LittleEndianRow row;
    (row.add(static_cast<uint32_t>(numbers)), ...);
    add(row.bytes(), std::byte{0});
  }
  /// Adds bytes, and fills up to a multiple of four bytes.
  void add(std::span<const std::byte> bytes, std::byte fill) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    bytes_.resize(padded(bytes_.size()), fill);
  }
  std::vector<std::byte> finish() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace

std::vector<std::byte> encodeGlb(const store::DecodedLod& lod, double step) {
  const Content content = contentOf(lod, step);
  const std::string text = Description(content).make().dump();
  const uint32_t json_bytes = padded(text.size());
  const uint32_t binary_bytes =
      padded(content.stream.bytes.size()) + static_cast<uint32_t>(content.normals.size());
  const uint32_t bytes = kHeaderBytes + kChunkHeaderBytes + json_bytes + kChunkHeaderBytes + binary_bytes;
  Chunks glb(bytes);
  glb.addNumbers(kMagic, kGlbVersion, bytes);
  glb.addNumbers(json_bytes, kJsonChunk);
  glb.add(std::as_bytes(std::span(text)), std::byte{' '});
  glb.addNumbers(binary_bytes, kBinaryChunk);
  glb.add(content.stream.bytes, std::byte{0});
  glb.add(content.normals, std::byte{0});
  return glb.finish();
}

}  // namespace lode::tiles
