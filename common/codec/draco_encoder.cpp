#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numeric>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include "common/codec/corner_normals.h"
#include "common/codec/draco_codec.h"
#include "common/codec/draco_stream.h"
#include "common/codec/octahedral.h"
#include "common/codec/surface_normals.h"
#include "common/error.h"
#include "common/image/image.h"
#include "common/limits.h"

namespace lode {
namespace {

using draco::GeometryAttribute;
using namespace draco_stream;

// Draco's speed setting. Below 4, Draco predicts texture coordinates with a method that can take seconds to
// decode damaged input.
constexpr int kSpeed = 4;
// Speed setting for meshes without attributes. With this setting Draco always continues at the vertex with
// the most known neighbours, which saves up to 15 % of the bytes if triangles are regular. Draco does not
// support this order for meshes with attributes.
constexpr int kSpeedOfPositionsAlone = 0;
// Largest number of triangles per vertex. To find the second triangle of an edge, Draco searches all
// triangles around one end of the edge. The search is slow at a vertex with very many triangles.
constexpr uint32_t kMostTrianglesOfVertex = 1024;
// Least number of vertices per listed normal (see encodeOtherNormals()) for which a payload omits its
// normals. A listed normal takes about 18 bits, and a normal that Draco encodes takes 5 to 8 bits.
constexpr size_t kLeastVerticesForOther = 4;

// Returns n steps as text that strtof() reads back exactly in any locale. Draco stores options as text, and
// its own conversion keeps only six decimals.
std::string hexFloat(uint32_t n, double step) {
  int exponent = 0;
  const auto eighths = static_cast<uint32_t>(8 * std::frexp(step, &exponent));
  char text[32];
  std::snprintf(text, sizeof text, "0x%xp%d", n * eighths, exponent - 3);
  return text;
}

// Returns a number that is not negative as text that strtof() reads back exactly in any locale.
std::string hexFloat(float value) {
  int exponent = 0;
  constexpr int kMantissaBits = 24;
  const auto mantissa = static_cast<uint32_t>(std::ldexp(std::frexp(value, &exponent), kMantissaBits));
  char text[32];
  std::snprintf(text, sizeof text, "0x%xp%d", mantissa, exponent - kMantissaBits);
  return text;
}

void requireSound(const Mesh& mesh) {
  const size_t vertices = mesh.positions.size();
  if (mesh.triangles.size() > kMaxLodTriangles || vertices > kMaxLodVertices)
    throw Error(ErrorCode::kLimit, "cannot encode a mesh of " + std::to_string(mesh.triangles.size()) +
                                       " triangles and " + std::to_string(vertices) +
                                       " vertices in one payload: build with smaller nodes");
  if (mesh.vertex_attributes.size() != (mesh.attributes.bits == 0 ? 0 : vertices) &&
      mesh.vertex_attributes.size() != vertices)
    throw Error(ErrorCode::kInternal, "a mesh to encode has attributes for some of its vertices only");
  for (const glm::u32vec3 t : mesh.triangles) {
    if (t.x >= vertices || t.y >= vertices || t.z >= vertices)
      throw Error(ErrorCode::kInternal, "a mesh to encode has a triangle with an index beyond its vertices");
    if (t.x == t.y || t.y == t.z || t.z == t.x)
      throw Error(ErrorCode::kInternal, "a mesh to encode has a triangle that uses a vertex twice");
  }
}

/// Duplicates vertices until none has more than kMostTrianglesOfVertex triangles. The new mesh has the same
/// triangles and can be encoded and decoded in a time proportional to their number. @return nothing if no
/// vertex has too many triangles.
std::optional<Mesh> spreadTriangles(const Mesh& mesh) {
  std::vector<uint32_t> uses(mesh.positions.size());
  for (const glm::u32vec3 t : mesh.triangles)
    for (int k = 0; k < 3; ++k) ++uses[t[k]];
  if (std::ranges::all_of(uses, [](uint32_t count) { return count <= kMostTrianglesOfVertex; }))
    return std::nullopt;
  Mesh spread = mesh;
  std::vector<uint32_t> copy(uses.size());  // for each vertex, index of the copy that the next triangle uses
  std::iota(copy.begin(), copy.end(), 0u);
  std::ranges::fill(uses, 0);
  for (glm::u32vec3& t : spread.triangles)
    for (int k = 0; k < 3; ++k) {
      const uint32_t vertex = t[k];
      if (uses[vertex]++ == kMostTrianglesOfVertex) {
        uses[vertex] = 1;
        copy[vertex] = static_cast<uint32_t>(spread.positions.size());
        spread.positions.push_back(mesh.positions[vertex]);
        if (!mesh.vertex_attributes.empty())
          spread.vertex_attributes.push_back(mesh.vertex_attributes[vertex]);
      }
      t[k] = copy[vertex];
    }
  return spread;
}

LatticeBox boxOf(const Mesh& mesh) {
  LatticeBox box;
  for (const PositionCode code : mesh.positions) box.add(unpackPosition(code));
  return box;
}

// Draco's type of a component.
template <typename T>
constexpr draco::DataType kDataType = draco::DT_INVALID;
template <>
constexpr draco::DataType kDataType<float> = draco::DT_FLOAT32;
template <>
constexpr draco::DataType kDataType<uint8_t> = draco::DT_UINT8;
template <>
constexpr draco::DataType kDataType<uint16_t> = draco::DT_UINT16;

// Adds an attribute. `write(i, T*)` writes the value of vertex i. Only bytes are normalized, that is, stand
// for numbers from 0 to 1. Returns the attribute's id.
template <typename T, typename Write>
int addAttribute(draco::Mesh& out, GeometryAttribute::Type type, int components, size_t vertices,
                 Write write) {
  GeometryAttribute attribute;
  attribute.Init(type, nullptr, static_cast<int8_t>(components), kDataType<T>, std::is_same_v<T, uint8_t>,
                 static_cast<int64_t>(sizeof(T)) * components, 0);
  const int id = out.AddAttribute(attribute, true, static_cast<uint32_t>(vertices));
  std::vector<T> values(vertices * static_cast<size_t>(components));
  for (size_t i = 0; i < vertices; ++i) write(i, &values[i * static_cast<size_t>(components)]);
  out.attribute(id)->buffer()->Write(0, values.data(), values.size() * sizeof(T));
  return id;
}

void setExplicitQuantization(draco::ExpertEncoder& encoder, int id, int bits, const std::string& origin,
                             double step, draco::PredictionSchemeMethod prediction) {
  draco::Options options;
  options.SetInt("quantization_bits", bits);
  options.SetString("quantization_origin", origin);
  options.SetString("quantization_range", hexFloat((1u << bits) - 1, step));
  options.SetInt("prediction_scheme", prediction);
  encoder.options().SetAttributeOptions(id, options);
}

bool hasTransparency(const Mesh& mesh) {
  return mesh.attributes.has(AttributeSet::kAlpha) &&
         std::any_of(mesh.vertex_attributes.begin(), mesh.vertex_attributes.end(),
                     [](const VertexAttributes& a) { return a.colour.a != 255; });
}

void addPositions(draco::Mesh& out, const Mesh& mesh, double step) {
  addAttribute<float>(out, GeometryAttribute::POSITION, 3, mesh.positions.size(), [&](size_t i, float* p) {
    const glm::vec3 value = glm::vec3(unpackPosition(mesh.positions[i])) * static_cast<float>(step);
    std::memcpy(p, &value, sizeof value);
  });
}

// Ids of the attributes in the Draco mesh; an id is empty if the mesh lacks the attribute.
struct AttributeIds {
  int position = 0;
  std::optional<int> normal, texture;
};

int addNormals(draco::Mesh& out, const Mesh& mesh) {
  const std::vector<VertexAttributes>& in = mesh.vertex_attributes;
  return addAttribute<float>(out, GeometryAttribute::NORMAL, 3, in.size(), [&](size_t i, float* n) {
    const glm::vec3 value = decodeOctahedral(in[i].normal);
    std::memcpy(n, &value, sizeof value);
  });
}

AttributeIds addAttributes(draco::Mesh& out, const Mesh& mesh, double step) {
  AttributeIds ids;
  addPositions(out, mesh, step);
  const std::vector<VertexAttributes>& in = mesh.vertex_attributes;
  if (mesh.attributes.has(AttributeSet::kNormal)) ids.normal = addNormals(out, mesh);
  if (mesh.attributes.has(AttributeSet::kColour | AttributeSet::kAlpha)) {
    const int components = hasTransparency(mesh) ? 4 : 3;
    addAttribute<uint8_t>(out, GeometryAttribute::COLOR, components, in.size(), [&](size_t i, uint8_t* c) {
      std::memcpy(c, &in[i].colour, static_cast<size_t>(components));
    });
  }
  if (mesh.attributes.has(AttributeSet::kTexture))
    ids.texture =
        addAttribute<float>(out, GeometryAttribute::TEX_COORD, 2, in.size(), [&](size_t i, float* t) {
          t[0] = static_cast<float>(in[i].texture.x * kTextureStep);
          t[1] = static_cast<float>(in[i].texture.y * kTextureStep);
        });
  if (mesh.attributes.has(AttributeSet::kMaterial))
    addAttribute<uint16_t>(out, GeometryAttribute::GENERIC, 1, in.size(),
                           [&](size_t i, uint16_t* m) { *m = in[i].material; });
  return ids;
}

void setQuantization(draco::ExpertEncoder& encoder, const AttributeIds& ids, const LatticeBox& box,
                     double step, MeshSource source) {
  const glm::uvec3 extent = box.max - box.min;
  const int bits = std::max(1, static_cast<int>(std::bit_width(std::max({extent.x, extent.y, extent.z}))));
  const std::string origin =
      hexFloat(box.min.x, step) + " " + hexFloat(box.min.y, step) + " " + hexFloat(box.min.z, step);
  // The multi-parallelogram predictor saves 3 to 20 % of the bytes if valences are regular, 5 to 8 % if most
  // vertices are locked (shared with other nodes), and 1 % otherwise. It makes decoding a third slower.
  const auto prediction = source == MeshSource::kSimplified
                              ? draco::MESH_PREDICTION_PARALLELOGRAM
                              : draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM;
  setExplicitQuantization(encoder, ids.position, bits, origin, step, prediction);
  if (ids.texture)
    setExplicitQuantization(encoder, *ids.texture, kTextureBits, "0 0", kTextureStep,
                            draco::MESH_PREDICTION_PARALLELOGRAM);
  if (ids.normal) {
    encoder.SetAttributeQuantization(*ids.normal, kNormalBits);
    // The geometric predictor makes a payload with normals 10 to 25 % smaller, but decoding takes 50 %
    // longer.
    encoder.SetAttributePredictionScheme(*ids.normal, draco::MESH_PREDICTION_GEOMETRIC_NORMAL);
  }
}

// Reads the number of decoded vertices from the payload's header. The number is exact, because attributes
// have no seams. Letting Draco count the vertices would make encoding 5 % slower.
uint32_t verticesOf(std::span<const std::byte> payload) {
  draco_stream::Cursor header(payload);
  header.skipStart();
  header.u8();
  return header.varint();
}

void addTriangles(draco::Mesh& out, const Mesh& mesh) {
  out.SetNumFaces(mesh.triangles.size());
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::u32vec3 t = mesh.triangles[i];
    out.SetFace(draco::FaceIndex(i),
                {draco::PointIndex(t.x), draco::PointIndex(t.y), draco::PointIndex(t.z)});
  }
  out.set_num_points(static_cast<uint32_t>(mesh.positions.size()));
}

EncodedPayload run(draco::ExpertEncoder& encoder, int speed) {
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(speed, speed);
  encoder.options().SetGlobalBool("split_mesh_on_seams", true);
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok())
    throw Error(ErrorCode::kInternal, std::string("Draco cannot encode a mesh: ") + status.error_msg());
  EncodedPayload payload;
  const auto bytes = std::as_bytes(std::span(buffer.data(), buffer.size()));
  payload.bytes.assign(bytes.begin(), bytes.end());
  payload.vertices = verticesOf(payload.bytes);
  return payload;
}

EncodedPayload encodeByDraco(const Mesh& mesh, double step, MeshSource source) {
  draco::Mesh in;
  addTriangles(in, mesh);
  const AttributeIds ids = addAttributes(in, mesh, step);
  draco::ExpertEncoder encoder(in);
  setQuantization(encoder, ids, boxOf(mesh), step, source);
  const bool positions_alone = source == MeshSource::kFile && mesh.attributes.bits == 0;
  return run(encoder, positions_alone ? kSpeedOfPositionsAlone : kSpeed);
}

// Adds colours in linear light. Returns the attribute's id.
int addLinearColours(draco::Mesh& out, const Mesh& mesh) {
  std::array<float, 256> linear{};
  for (size_t byte = 0; byte < linear.size(); ++byte)
    linear[byte] = static_cast<float>(linearOf(static_cast<uint8_t>(byte)));
  return addAttribute<float>(out, GeometryAttribute::COLOR, 3, mesh.vertex_attributes.size(),
                             [&](size_t i, float* c) {
                               const glm::u8vec4 colour = mesh.vertex_attributes[i].colour;
                               for (int k = 0; k < 3; ++k) c[k] = linear[colour[k]];
                             });
}

// Adds texture coordinates on the grid of a glTF stream. Returns the attribute's id.
int addCoordinates(draco::Mesh& out, const Mesh& mesh, const GltfCoordinates& grid) {
  return addAttribute<float>(
      out, GeometryAttribute::TEX_COORD, 2, mesh.vertex_attributes.size(), [&](size_t i, float* t) {
        for (int k = 0; k < 2; ++k)
          t[k] = static_cast<float>(grid.origin[k] + mesh.vertex_attributes[i].texture[k] * grid.step);
      });
}

/// Encodes a mesh without its normals, if the build computed them and most of them follow from the mesh's own
/// triangles, as in a leaf. The payload ends with a list of the other normals.
/// @return nothing for other meshes.
std::optional<EncodedPayload> encodeWithoutNormals(const Mesh& mesh, double step, MeshSource source) {
  if (!mesh.attributes.has(AttributeSet::kNormal) || !mesh.attributes.has(AttributeSet::kComputedNormal))
    return std::nullopt;
  const std::vector<uint16_t> surface = surfaceNormals(mesh);
  size_t others = 0;
  for (uint32_t v = 0; v < surface.size(); ++v) others += surface[v] != mesh.vertex_attributes[v].normal;
  if (others > surface.size() / kLeastVerticesForOther) return std::nullopt;

  Mesh bare = mesh;
  bare.attributes.bits &= static_cast<uint8_t>(~(AttributeSet::kNormal | AttributeSet::kComputedNormal));
  if (bare.attributes.bits == 0) bare.vertex_attributes.clear();
  EncodedPayload payload = encodeByDraco(bare, step, source);
  const Mesh decoded = decodePayload(
      payload.bytes, step,
      {static_cast<uint32_t>(mesh.triangles.size()), payload.vertices, bare.attributes, boxOf(mesh)});
  const std::optional<std::vector<uint16_t>> wanted = CornerNormals(mesh).ofVertices(decoded);
  if (!wanted) return std::nullopt;
  const std::vector<std::byte> list = encodeOtherNormals(surfaceNormals(decoded), *wanted);
  payload.bytes.insert(payload.bytes.end(), list.begin(), list.end());
  return payload;
}

}  // namespace

EncodedPayload encodePayload(const Mesh& given, double step, MeshSource source) {
  if (given.triangles.empty()) return {};
  if (!isLatticeStep(step))
    throw Error(ErrorCode::kInternal,
                "cannot encode a mesh: a store cannot contain the lattice step of the mesh");
  requireSound(given);
  const std::optional<Mesh> spread = spreadTriangles(given);
  const Mesh& mesh = spread ? *spread : given;
  if (std::optional<EncodedPayload> payload = encodeWithoutNormals(mesh, step, source)) return *payload;
  return encodeByDraco(mesh, step, source);
}

GltfStream encodeForGltf(const Mesh& given, double step, const GltfCoordinates* coordinates) {
  requireSound(given);
  const std::optional<Mesh> spread = spreadTriangles(given);
  const Mesh& mesh = spread ? *spread : given;
  draco::Mesh in;
  addTriangles(in, mesh);
  addPositions(in, mesh, step);
  AttributeIds ids;
  GltfStream stream;
  if (mesh.attributes.has(AttributeSet::kNormal)) stream.ids.normal = ids.normal = addNormals(in, mesh);
  std::optional<int> colour;
  if (mesh.attributes.has(AttributeSet::kColour | AttributeSet::kAlpha)) {
    stream.ids.colour = colour = addLinearColours(in, mesh);
    stream.ids.colour_components = 3;
  }
  std::optional<int> texture;
  if (coordinates) stream.ids.texture = texture = addCoordinates(in, mesh, *coordinates);
  draco::ExpertEncoder encoder(in);
  setQuantization(encoder, ids, boxOf(mesh), step, MeshSource::kSimplified);
  if (colour) {
    draco::Options options;
    options.SetInt("quantization_bits", kGltfColourBits);
    options.SetString("quantization_origin", "0 0 0 0");
    options.SetString("quantization_range", "1");
    // For colours this predictor saves 3 to 4 % of a stream and makes decoding a sixth slower.
    options.SetInt("prediction_scheme", draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM);
    encoder.options().SetAttributeOptions(*colour, options);
  }
  if (texture)
    setExplicitQuantization(encoder, *texture, coordinates->bits,
                            hexFloat(coordinates->origin.x) + " " + hexFloat(coordinates->origin.y),
                            coordinates->step, draco::MESH_PREDICTION_PARALLELOGRAM);
  EncodedPayload encoded = run(encoder, kSpeed);
  stream.bytes = std::move(encoded.bytes);
  stream.vertices = encoded.vertices;
  return stream;
}

}  // namespace lode
