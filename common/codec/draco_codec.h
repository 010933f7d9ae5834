#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// What a hierarchy page announces of a payload; the decoder compares before it takes memory.
struct PayloadExpectation {
  uint32_t triangles = 0;
  uint32_t vertices = 0;    ///< at most this many decoded vertices (the encoder's count)
  AttributeSet attributes;  ///< those of the model
  LatticeBox box;           ///< the node's box; a position outside is an error
};

struct EncodedPayload {
  std::vector<std::byte> bytes;  ///< empty for a mesh without triangles
  uint32_t vertices = 0;         ///< vertices that a decoder will produce
};

/// Where a mesh's triangles come from: those of a file are often regular, and those of a far LOD few and
/// for the most part border; both are predicted more closely.
enum class MeshSource { kFile, kSimplified, kFarLod };

/// Encodes an LOD with Draco's edgebreaker (settings: docs/store-format.md), float positions in the model
/// frame. The decoded mesh has the same triangles (as sets of position and attributes, orientation kept) in
/// another order. Computed normals that the surface gives are left out, where they are most.
/// @param step  the lattice's step.
/// @throws Error kInternal if Draco fails. Thread safe.
EncodedPayload encodePayload(const Mesh& mesh, double step, MeshSource source = MeshSource::kSimplified);

/// Decodes a payload from an untrusted source, guarded as docs/protocol.md says: header and counts are
/// checked before memory is taken, every index, position and attribute afterwards.
/// @throws Error kFormat or kLimit. Thread safe.
Mesh decodePayload(std::span<const std::byte> bytes, double step, const PayloadExpectation& expected);

}  // namespace lode
