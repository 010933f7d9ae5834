#include "server/tiles/glb.h"

#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/io/little_endian_row.h"

namespace lode::tiles {
namespace {

using Json = nlohmann::ordered_json;

// Constants of the glTF specification.
constexpr uint32_t kMagic = 0x46546c67, kGlbVersion = 2, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;
constexpr int kByte = 5120, kUnsignedInt = 5125, kFloat = 5126, kVertexBuffer = 34962;
constexpr int kClampToEdge = 33071, kRepeat = 10497, kLinear = 9729, kLinearMipmapLinear = 9987;
constexpr uint32_t kHeaderBytes = 12, kChunkHeaderBytes = 8;

uint32_t padded(size_t bytes) { return static_cast<uint32_t>((bytes + 3) / 4 * 4); }

/// Builds the JSON chunk of a GLB, part by part.
class Description {
 public:
  explicit Description(const GlbContent& content) : content_(content) {}

  Json make() {
    for (const GlbPart& part : content_.parts) addPart(part);
    for (const GlbImage& image : content_.images) addImage(image);
    return document();
  }

  /// Returns the parts of the binary chunk, in order. Each is padded to four bytes.
  std::span<const std::span<const std::byte>> binary() const noexcept { return binary_; }
  uint32_t binaryBytes() const noexcept { return binary_bytes_; }

 private:
  void addPart(const GlbPart& part) {
    Json in_stream = Json::object(), attributes = Json::object();
    const auto add = [&](const char* name, const char* type, uint32_t id) {
      attributes[name] = accessors_.size();
      in_stream[name] = id;
      accessors_.push_back({{"componentType", kFloat}, {"count", part.stream.vertices}, {"type", type}});
    };
    const StreamIds& ids = part.stream.ids;
    add("POSITION", "VEC3", ids.position);
    const auto& [least, most] = part.bounds;
    accessors_.back()["min"] = {least.x, least.y, least.z};
    accessors_.back()["max"] = {most.x, most.y, most.z};
    if (ids.normal) add("NORMAL", "VEC3", *ids.normal);
    if (ids.colour) add("COLOR_0", ids.colour_components == 4 ? "VEC4" : "VEC3", *ids.colour);
    if (part.image && ids.texture) add("TEXCOORD_0", "VEC2", *ids.texture);
    const size_t stream = addView(part.stream.bytes);
    if (!part.normals.empty()) {
      attributes["NORMAL"] = accessors_.size();
      addNormals(part);
    }
    accessors_.push_back(
        {{"componentType", kUnsignedInt}, {"count", 3 * part.triangles}, {"type", "SCALAR"}});
    primitives_.push_back(
        {{"attributes", std::move(attributes)},
         {"indices", accessors_.size() - 1},
         {"material", primitives_.size()},
         {"extensions",
          {{"KHR_draco_mesh_compression", {{"bufferView", stream}, {"attributes", std::move(in_stream)}}}}}});
    addMaterial(part.image);
  }

  size_t addView(std::span<const std::byte> bytes) {
    Json view{{"buffer", 0}};
    if (binary_bytes_ > 0) view["byteOffset"] = binary_bytes_;
    view["byteLength"] = bytes.size();
    views_.push_back(std::move(view));
    binary_.push_back(bytes);
    binary_bytes_ += padded(bytes.size());
    return views_.size() - 1;
  }

  void addNormals(const GlbPart& part) {
    has_quantized_ = true;
    const size_t number = addView(part.normals);
    views_[number]["byteStride"] = kGlbNormalBytes;
    views_[number]["target"] = kVertexBuffer;
    accessors_.push_back({{"bufferView", number},
                          {"componentType", kByte},
                          {"normalized", true},
                          {"count", part.stream.vertices},
                          {"type", "VEC3"}});
  }

  void addMaterial(std::optional<uint32_t> image) {
    Json material{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                  {"doubleSided", true}};
    if (image) {
      material["pbrMetallicRoughness"]["baseColorTexture"]["index"] = *image;
      if (content_.images[*image].cuts_out) material["alphaMode"] = "MASK";
    }
    materials_.push_back(std::move(material));
  }

  /// Adds an image with a texture and a sampler of its own.
  void addImage(const GlbImage& image) {
    Json source;
    if (image.uri.empty()) {
      source["bufferView"] = addView(image.inside);
      source["mimeType"] = image.is_webp ? "image/webp" : "image/jpeg";
    } else {
      source["uri"] = image.uri;
    }
    Json texture{{"sampler", images_.size()}};
    if (image.is_webp)
      texture["extensions"]["EXT_texture_webp"]["source"] = images_.size();
    else
      texture["source"] = images_.size();
    has_webp_ |= image.is_webp;
    const int wrap = image.repeats ? kRepeat : kClampToEdge;
    samplers_.push_back(
        {{"magFilter", kLinear}, {"minFilter", kLinearMipmapLinear}, {"wrapS", wrap}, {"wrapT", wrap}});
    textures_.push_back(std::move(texture));
    images_.push_back(std::move(source));
  }

  Json document() {
    Json extensions = Json::array({"KHR_draco_mesh_compression"});
    if (has_quantized_) extensions.push_back("KHR_mesh_quantization");
    if (has_webp_) extensions.push_back("EXT_texture_webp");
    Json document;
    document["asset"] = {{"version", "2.0"}, {"generator", "Lodestream"}};
    document["extensionsUsed"] = extensions;
    document["extensionsRequired"] = std::move(extensions);
    document["scene"] = 0;
    document["scenes"][0]["nodes"][0] = 0;
    document["nodes"][0] = {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1}}};
    document["meshes"][0]["primitives"] = std::move(primitives_);
    document["materials"] = std::move(materials_);
    if (!images_.empty()) {
      document["textures"] = std::move(textures_);
      document["samplers"] = std::move(samplers_);
      document["images"] = std::move(images_);
    }
    document["accessors"] = std::move(accessors_);
    document["bufferViews"] = std::move(views_);
    document["buffers"][0]["byteLength"] = binary_bytes_;
    return document;
  }

  const GlbContent& content_;
  Json primitives_ = Json::array(), materials_ = Json::array(), accessors_ = Json::array();
  Json views_ = Json::array(), images_ = Json::array(), textures_ = Json::array(), samplers_ = Json::array();
  std::vector<std::span<const std::byte>> binary_;
  uint32_t binary_bytes_ = 0;
  bool has_quantized_ = false, has_webp_ = false;
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
  /// Adds bytes, and pads the chunk to a multiple of four bytes.
  void add(std::span<const std::byte> bytes, std::byte fill) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    bytes_.resize(padded(bytes_.size()), fill);
  }
  std::vector<std::byte> finish() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace

std::vector<std::byte> encodeGlb(const GlbContent& content) {
  Description description(content);
  const std::string text = description.make().dump();
  const uint32_t json_bytes = padded(text.size()), binary_bytes = description.binaryBytes();
  const uint32_t bytes = kHeaderBytes + kChunkHeaderBytes + json_bytes + kChunkHeaderBytes + binary_bytes;
  Chunks glb(bytes);
  glb.addNumbers(kMagic, kGlbVersion, bytes);
  glb.addNumbers(json_bytes, kJsonChunk);
  glb.add(std::as_bytes(std::span(text)), std::byte{' '});
  glb.addNumbers(binary_bytes, kBinaryChunk);
  for (const std::span<const std::byte> part : description.binary()) glb.add(part, std::byte{0});
  return glb.finish();
}

}  // namespace lode::tiles
