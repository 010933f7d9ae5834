#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Properties that a hierarchy page announces for a payload. The decoder checks them before it allocates
/// memory.
struct PayloadExpectation {
  uint32_t triangles = 0;
  uint32_t vertices = 0;    ///< largest number of decoded vertices; the encoder has counted them
  AttributeSet attributes;  ///< attributes of the model
  LatticeBox box;           ///< box of the node, which must contain all positions
};

struct EncodedPayload {
  std::vector<std::byte> bytes;  ///< the payload; empty for a mesh without triangles
  uint32_t vertices = 0;         ///< number of vertices after decoding
};

/// Origin of a mesh's triangles, which selects the predictor of positions. kFile and kFarLod select a
/// predictor that saves more bytes but decodes more slowly. Triangles of a file are often regular, and those
/// of far LODs mostly touch the node's border; both suit this predictor.
enum class MeshSource { kFile, kSimplified, kFarLod };

/// Encodes an LOD with Draco's edgebreaker, with float positions in the model frame. docs/store-format.md
/// lists the settings. The decoded mesh has the same triangles, with equal positions, attributes and
/// orientation, in another order. If the build computed the normals and most of them follow from the
/// triangles, the payload omits these normals.
/// @param step  step of the lattice.
/// @throws Error kInternal if Draco fails. Thread safe.
EncodedPayload encodePayload(const Mesh& mesh, double step, MeshSource source = MeshSource::kSimplified);

/// Ids of the attributes of a payload's Draco stream. The extension KHR_draco_mesh_compression of glTF refers
/// to attributes by these ids. An id is empty if the stream lacks the attribute.
struct StreamIds {
  uint32_t position = 0;
  std::optional<uint32_t> normal, colour, texture, material;
  uint32_t colour_components = 0;  ///< 3, 4 with alpha, or 0 without colours

  bool operator==(const StreamIds&) const = default;
};

/// Decodes a payload from an untrusted source. Checks the header and all counts before it allocates memory,
/// and every index, position and attribute afterwards (docs/protocol.md).
/// @param ids  if not null, receives the ids of the stream's attributes.
/// @throws Error kFormat or kLimit. Thread safe.
Mesh decodePayload(std::span<const std::byte> bytes, double step, const PayloadExpectation& expected,
                   StreamIds* ids = nullptr);

/// Number of bits per component of the colours of encodeForGltf(). Equal colours of two streams decode to
/// equal floats, because all streams share the grid k / 1023.
constexpr int kGltfColourBits = 10;

/// A Draco stream for glTF, which no payload decoder accepts.
struct GltfStream {
  std::vector<std::byte> bytes;
  uint32_t vertices = 0;  ///< number of vertices after decoding
  StreamIds ids;
};

/// Grid of the texture coordinates in a stream for glTF: coordinates = origin + code * step.
struct GltfCoordinates {
  glm::vec2 origin{0};  ///< not negative
  double step = 0;      ///< a power of two
  int bits = 0;         ///< all codes are below 2^bits; at most 16
};

/// Encodes positions, normals and colours of an LOD for glTF, which requires colours in linear light. COLOR
/// consists of three floats from 0 to 1; alpha is left out, because the client does not draw it either.
/// Positions and normals decode to the same floats as those of a payload. Materials are left out.
/// @param coordinates  grid of the codes in VertexAttributes::texture; if null, the stream has no texture
///                     coordinates.
/// @throws Error kInternal if Draco fails. Thread safe.
GltfStream encodeForGltf(const Mesh& mesh, double step, const GltfCoordinates* coordinates = nullptr);

}  // namespace lode
