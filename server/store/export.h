#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "common/codec/draco_codec.h"
#include "common/io/mesh_materials.h"
#include "common/mesh.h"
#include "server/store/cut.h"
#include "server/store/reader.h"

namespace lode::store {

/// Writes a store's textures as PNG files at full size, without further loss, next to a mesh file:
/// STEM_NAME.png, where STEM is the mesh file's name without extension and NAME is the texture's name without
/// folders. Keeps one row of tiles in memory.
/// @throws Error kIo, kFormat, kLimit.
ImageFiles exportTextures(const Reader& reader, const std::filesystem::path& mesh);

/// A payload with its mesh.
struct DecodedLod {
  std::vector<std::byte> payload;  ///< empty for an LOD without triangles
  Mesh mesh;
  StreamIds ids;  ///< ids of the attributes in the payload's Draco stream
};

/// Reads, decodes and validates one (node, LOD). For an LOD without triangles, returns an empty mesh.
/// @throws Error kIo, kFormat or kLimit, naming file and node. Thread safe.
DecodedLod decodeLod(const Reader& reader, const Node& node, uint32_t lod);

/// Returns the mesh of decodeLod(). @throws Error like decodeLod(). Thread safe.
Mesh readLod(const Reader& reader, const Node& node, uint32_t lod);

/// Joins a cut into one mesh. Merges vertices with equal position and attributes, and numbers vertices in
/// order of first use.
/// @throws Error like readLod(); kLimit if the mesh has too many vertices for 32-bit indices. Thread safe.
Mesh assembleCut(const Reader& reader, const Cut& cut);

/// Writes a cut in the format of the path's extension (see writeMesh()), and the store's textures next to the
/// file (see exportTextures()). @return the files written next to it. @throws Error like writeMesh() and
/// exportTextures().
std::vector<std::filesystem::path> exportCut(const Reader& reader, const Cut& cut,
                                             const std::filesystem::path& path);

}  // namespace lode::store
