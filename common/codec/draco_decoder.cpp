#include <cmath>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>

#include <draco/attributes/attribute_octahedron_transform.h>
#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/mesh/mesh.h>

#include "common/codec/draco_codec.h"
#include "common/codec/draco_stream.h"
#include "common/codec/surface_normals.h"
#include "common/error.h"
#include "common/limits.h"

namespace lode {
namespace {

using draco::GeometryAttribute;
using draco::PointAttribute;
using namespace draco_stream;

using draco_stream::refuse;

// Checks all numbers by which Draco sizes its tables. Source: Draco's bitstream specification 2.2, sections 3
// and 6.
void checkHeader(std::span<const std::byte> bytes, const PayloadExpectation& expected) {
  if (expected.triangles > kMaxLodTriangles || expected.vertices > kMaxLodVertices)
    throw Error(ErrorCode::kLimit, "a payload of " + std::to_string(expected.triangles) + " triangles and " +
                                       std::to_string(expected.vertices) + " vertices exceeds the limits");
  draco_stream::Cursor header(bytes);
  header.skipStart();
  const uint8_t traversal = header.u8();
  if (traversal != draco::MESH_EDGEBREAKER_STANDARD_ENCODING &&
      traversal != draco::MESH_EDGEBREAKER_VALENCE_ENCODING)
    refuse("unknown edgebreaker traversal");
  const uint32_t vertices = header.varint();
  const uint32_t faces = header.varint();
  if (faces != expected.triangles)
    refuse("it declares " + std::to_string(faces) + " triangles, but the hierarchy has " +
           std::to_string(expected.triangles));
  if (vertices > expected.vertices)
    refuse("it declares " + std::to_string(vertices) + " vertices, but the hierarchy has " +
           std::to_string(expected.vertices));
  // Refuse attributes with seams, because each such attribute would need a face table of its own.
  if (header.u8() != 0) refuse("it has attributes with seams");
  const uint32_t symbols = header.varint();
  if (symbols > faces || header.varint() > symbols)
    refuse("its connectivity has more symbols than triangles");
}

bool leavesNormalsOut(const draco::Mesh& in, AttributeSet attributes) {
  return attributes.has(AttributeSet::kNormal) && attributes.has(AttributeSet::kComputedNormal) &&
         in.GetNamedAttribute(GeometryAttribute::NORMAL) == nullptr;
}

// Draco's decoder with a check before it decodes attributes: the payload must declare exactly the model's
// attributes. A hostile payload could declare any number of attributes of any width.
class GuardedDecoder : public draco::MeshEdgebreakerDecoder {
 public:
  explicit GuardedDecoder(const PayloadExpectation& expected) : expected_(expected) {}
  const std::string& refusal() const noexcept { return refusal_; }

 private:
  bool DecodeAllAttributes() override {
    refusal_ = checkCounts();
    if (refusal_.empty()) refusal_ = checkAttributes();
    return refusal_.empty() && draco::MeshEdgebreakerDecoder::DecodeAllAttributes();
  }

  std::string checkCounts() const {
    if (mesh()->num_faces() != expected_.triangles) return "its triangles are not as many as announced";
    if (mesh()->num_points() > expected_.vertices) return "it has more vertices than announced";
    return {};
  }

  std::string checkAttributes() const {
    const AttributeSet set = expected_.attributes;
    const bool alpha = set.has(AttributeSet::kAlpha);
    const bool normal = set.has(AttributeSet::kNormal) && !leavesNormalsOut(*mesh(), set);
    int wanted = 0;
    const auto fits = [&](GeometryAttribute::Type type, bool has, draco::DataType data_type, int least,
                          int most) {
      if (mesh()->NumNamedAttributes(type) != (has ? 1 : 0)) return false;
      wanted += has ? 1 : 0;
      const PointAttribute* attribute = mesh()->GetNamedAttribute(type);
      return !has || (attribute->data_type() == data_type && attribute->num_components() >= least &&
                      attribute->num_components() <= most);
    };
    const bool all_fit =
        fits(GeometryAttribute::POSITION, true, draco::DT_FLOAT32, 3, 3) &&
        fits(GeometryAttribute::NORMAL, normal, draco::DT_FLOAT32, 3, 3) &&
        fits(GeometryAttribute::COLOR, set.has(AttributeSet::kColour | AttributeSet::kAlpha), draco::DT_UINT8,
             3, alpha ? 4 : 3) &&
        fits(GeometryAttribute::TEX_COORD, set.has(AttributeSet::kTexture), draco::DT_FLOAT32, 2, 2) &&
        fits(GeometryAttribute::GENERIC, set.has(AttributeSet::kMaterial), draco::DT_UINT16, 1, 1);
    return all_fit && wanted == mesh()->num_attributes() ? "" : "its attributes are not those of the model";
  }

  const PayloadExpectation& expected_;
  std::string refusal_;
};

// Calls `use(vertex, const T* value)` for every decoded vertex.
template <typename T, typename Use>
void forEachValue(const draco::Mesh& in, const PointAttribute& attribute, int components, Use use) {
  if (attribute.num_components() != components || attribute.byte_stride() != components * int(sizeof(T)) ||
      attribute.buffer()->data_size() < attribute.size() * sizeof(T) * static_cast<size_t>(components))
    refuse("an attribute has another layout than announced");
  const T* values = reinterpret_cast<const T*>(attribute.buffer()->data());
  for (uint32_t i = 0; i < in.num_points(); ++i) {
    const uint32_t value = attribute.mapped_index(draco::PointIndex(i)).value();
    if (value >= attribute.size()) refuse("a vertex lacks an attribute");
    use(i, values + static_cast<size_t>(value) * static_cast<size_t>(components));
  }
}

// Returns value / step. Refuses the payload unless the result is a lattice coordinate.
uint32_t wholeSteps(float value, double step) {
  const double steps = value / step;
  if (!(steps >= 0 && steps <= kMaxLattice) || steps != std::floor(steps))
    refuse("its positions are off the lattice");
  return static_cast<uint32_t>(steps);
}

// Reads positions from the quantized integers q. A decoder that uses Draco's floats gets the same positions,
// because origin + q * range / (2^bits - 1) is exact in float for all payloads of our encoder.
void readPositions(const draco::Mesh& in, double step, const LatticeBox& box, Mesh& mesh) {
  const PointAttribute& attribute = *in.GetNamedAttribute(GeometryAttribute::POSITION);
  draco::AttributeQuantizationTransform transform;
  if (attribute.GetAttributeTransformData() == nullptr || !transform.InitFromAttribute(attribute))
    refuse("its positions are not quantized");
  const int bits = transform.quantization_bits();
  if (bits < 1 || bits > kLatticeBits) refuse("its positions have more bits than the lattice");
  const glm::uvec3 origin(wholeSteps(transform.min_value(0), step), wholeSteps(transform.min_value(1), step),
                          wholeSteps(transform.min_value(2), step));
  if (static_cast<double>(transform.range()) != step * ((1u << bits) - 1))
    refuse("its positions are off the lattice");
  mesh.positions.resize(in.num_points());
  const glm::uvec3 least = box.min, most = glm::min(box.max, glm::uvec3(kMaxLattice));
  forEachValue<uint32_t>(in, attribute, 3, [&](uint32_t vertex, const uint32_t* q) {
    if ((q[0] | q[1] | q[2]) > kMaxLattice) refuse("a position is off the lattice");
    const glm::uvec3 p(origin.x + q[0], origin.y + q[1], origin.z + q[2]);
    if (glm::any(glm::lessThan(p, least)) || glm::any(glm::greaterThan(p, most)))
      refuse("a position is outside the node's box");
    mesh.positions[vertex] = packPosition(p);
  });
}

void readNormals(const draco::Mesh& in, Mesh& mesh) {
  const PointAttribute& attribute = *in.GetNamedAttribute(GeometryAttribute::NORMAL);
  draco::AttributeOctahedronTransform transform;
  if (attribute.GetAttributeTransformData() == nullptr || !transform.InitFromAttribute(attribute) ||
      transform.quantization_bits() != kNormalBits)
    refuse("its normals are not octahedral with 8 bits");
  forEachValue<uint32_t>(in, attribute, 2, [&](uint32_t vertex, const uint32_t* q) {
    if (q[0] > 254 || q[1] > 254) refuse("a normal is off the octahedron");
    mesh.vertex_attributes[vertex].normal = static_cast<uint16_t>(q[0] | q[1] << 8);
  });
}

void readColours(const draco::Mesh& in, Mesh& mesh) {
  const PointAttribute& attribute = *in.GetNamedAttribute(GeometryAttribute::COLOR);
  const int components = attribute.num_components();
  forEachValue<uint8_t>(in, attribute, components, [&](uint32_t vertex, const uint8_t* c) {
    mesh.vertex_attributes[vertex].colour = glm::u8vec4(c[0], c[1], c[2], components == 4 ? c[3] : 255);
  });
}

void readTexture(const draco::Mesh& in, Mesh& mesh) {
  const PointAttribute& attribute = *in.GetNamedAttribute(GeometryAttribute::TEX_COORD);
  draco::AttributeQuantizationTransform transform;
  if (attribute.GetAttributeTransformData() == nullptr || !transform.InitFromAttribute(attribute) ||
      transform.quantization_bits() != kTextureBits || transform.min_value(0) != 0 ||
      transform.min_value(1) != 0 || transform.range() != static_cast<float>(65535 * kTextureStep))
    refuse("its texture coordinates are off the model's grid");
  forEachValue<uint32_t>(in, attribute, 2, [&](uint32_t vertex, const uint32_t* q) {
    if ((q[0] | q[1]) > 65535) refuse("a texture coordinate is off the model's grid");
    mesh.vertex_attributes[vertex].texture = glm::u16vec2(q[0], q[1]);
  });
}

void readAttributes(const draco::Mesh& in, Mesh& mesh) {
  const AttributeSet set = mesh.attributes;
  if (set.bits == 0) return;
  mesh.vertex_attributes.resize(in.num_points());
  if (in.GetNamedAttribute(GeometryAttribute::NORMAL) != nullptr) readNormals(in, mesh);
  if (set.has(AttributeSet::kColour | AttributeSet::kAlpha)) readColours(in, mesh);
  if (set.has(AttributeSet::kTexture)) readTexture(in, mesh);
  if (set.has(AttributeSet::kMaterial))
    forEachValue<uint16_t>(
        in, *in.GetNamedAttribute(GeometryAttribute::GENERIC), 1,
        [&](uint32_t vertex, const uint16_t* m) { mesh.vertex_attributes[vertex].material = *m; });
}

void readTriangles(const draco::Mesh& in, Mesh& mesh) {
  const uint32_t vertices = in.num_points();
  mesh.triangles.resize(in.num_faces());
  for (uint32_t i = 0; i < in.num_faces(); ++i) {
    const draco::Mesh::Face& face = in.face(draco::FaceIndex(i));
    const glm::u32vec3 t(face[0].value(), face[1].value(), face[2].value());
    if (t.x >= vertices || t.y >= vertices || t.z >= vertices)
      refuse("a triangle has an index beyond the vertices");
    if (t.x == t.y || t.y == t.z || t.z == t.x) refuse("a triangle uses a vertex twice");
    mesh.triangles[i] = t;
  }
}

/// Decodes a stream with GuardedDecoder. @return the bytes that follow the stream.
std::span<const std::byte> decodeGuarded(std::span<const std::byte> bytes, const PayloadExpectation& expected,
                                         draco::Mesh& out) {
  draco::DecoderOptions options;  // the options below keep Draco from converting quantized integers to floats
  for (const auto type :
       {GeometryAttribute::POSITION, GeometryAttribute::NORMAL, GeometryAttribute::TEX_COORD})
    options.SetAttributeBool(type, "skip_attribute_transform", true);
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  GuardedDecoder decoder(expected);
  try {
    const draco::Status status = decoder.Decode(options, &buffer, &out);
    if (!decoder.refusal().empty()) refuse(decoder.refusal());
    if (!status.ok()) refuse(std::string("Draco says: ") + status.error_msg());
  } catch (const std::bad_alloc&) {
    refuse("it asks for too much memory");
  } catch (const std::length_error&) {
    refuse("it asks for too much memory");
  }
  const auto rest = static_cast<uint64_t>(buffer.remaining_size());
  if (rest > bytes.size()) refuse("it is cut off");
  return bytes.last(rest);
}

StreamIds idsOf(const draco::Mesh& in) {
  const auto idOf = [&](GeometryAttribute::Type type) -> std::optional<uint32_t> {
    const PointAttribute* const attribute = in.GetNamedAttribute(type);
    return attribute == nullptr ? std::nullopt : std::optional(attribute->unique_id());
  };
  StreamIds ids;
  ids.position = *idOf(GeometryAttribute::POSITION);
  ids.normal = idOf(GeometryAttribute::NORMAL);
  ids.colour = idOf(GeometryAttribute::COLOR);
  ids.texture = idOf(GeometryAttribute::TEX_COORD);
  ids.material = idOf(GeometryAttribute::GENERIC);
  if (ids.colour)
    ids.colour_components =
        static_cast<uint32_t>(in.GetNamedAttribute(GeometryAttribute::COLOR)->num_components());
  return ids;
}

}  // namespace

Mesh decodePayload(std::span<const std::byte> bytes, double step, const PayloadExpectation& expected,
                   StreamIds* ids) {
  if (!isLatticeStep(step)) refuse("a store cannot hold this lattice step");
  Mesh mesh;
  mesh.attributes = expected.attributes;
  if (bytes.empty() && expected.triangles == 0) return mesh;
  checkHeader(bytes, expected);
  draco::Mesh decoded;
  const std::span<const std::byte> rest = decodeGuarded(bytes, expected, decoded);
  readTriangles(decoded, mesh);
  readPositions(decoded, step, expected.box, mesh);
  readAttributes(decoded, mesh);
  if (ids != nullptr) *ids = idsOf(decoded);
  if (leavesNormalsOut(decoded, expected.attributes))
    giveNormals(mesh, rest);
  else if (!rest.empty())
    refuse("bytes follow its end");
  return mesh;
}

}  // namespace lode
