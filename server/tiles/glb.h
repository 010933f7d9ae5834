#pragma once

#include <cstddef>
#include <vector>

#include "server/store/export.h"

namespace lode::tiles {

/// Returns an LOD as binary glTF 2.0 with the extension KHR_draco_mesh_compression. The Draco stream is the
/// payload itself, except for LODs with colours: glTF requires linear colours, so their streams are encoded
/// again (encodeForGltf()). If the payload leaves the normals out, they follow the stream as three signed
/// bytes per vertex (KHR_mesh_quantization). The mesh is in the model frame, turned from z up to y up, which
/// viewers of 3D Tiles undo. Textures are left out. The bytes depend only on the payload.
/// @param lod   an LOD with triangles.
/// @param step  step of the lattice.
/// @throws Error kInternal if Draco fails. Thread safe.
std::vector<std::byte> encodeGlb(const store::DecodedLod& lod, double step);

}  // namespace lode::tiles
