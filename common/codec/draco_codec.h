#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Properties of a payload as its hierarchy page announces them. The decoder checks them before it allocates.
struct PayloadExpectation {
  uint32_t triangles = 0;
  uint32_t vertices = 0;    ///< largest number of decoded vertices, which the encoder counted
  AttributeSet attributes;  ///< attributes of the model
  LatticeBox box;           ///< box of the node, which must contain all positions
};

struct EncodedPayload {
  std::vector<std::byte> bytes;  ///< the payload; empty for a mesh without triangles
  uint32_t vertices = 0;         ///< number of vertices after decoding
};

/// Origin of a mesh's triangles. kFile and kFarLod select a predictor that saves more bytes but decodes more
/// slowly: triangles of a file are often regular, and most triangles of a far LOD are at the boundary.
enum class MeshSource { kFile, kSimplified, kFarLod };

/// Encodes an LOD with Draco's edgebreaker (settings: docs/store-format.md), float positions in the model
/// frame. The decoded mesh has the same triangles, with equal positions, attributes and orientation, in
/// another order. Omits computed normals if most normals follow from the triangles.
/// @param step  step of the lattice.
/// @throws Error kInternal if Draco fails. Thread safe.
EncodedPayload encodePayload(const Mesh& mesh, double step, MeshSource source = MeshSource::kSimplified);

/// Decodes a payload from an untrusted source. Checks the header and all counts before it allocates memory,
/// and every index, position and attribute afterwards (docs/protocol.md).
/// @throws Error kFormat or kLimit. Thread safe.
Mesh decodePayload(std::span<const std::byte> bytes, double step, const PayloadExpectation& expected);

}  // namespace lode
