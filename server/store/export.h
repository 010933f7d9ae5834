#pragma once

#include <filesystem>

#include "common/io/mesh_materials.h"
#include "common/mesh.h"
#include "server/store/cut.h"
#include "server/store/reader.h"

namespace lode::store {

/// Writes a store's textures as PNG files at full size, without further loss, next to a mesh file:
/// STEM_NAME.png, with the mesh file's stem and the texture's name without folders. Memory: one row of tiles.
/// @throws Error kIo, kFormat, kLimit.
ImageFiles exportTextures(const Reader& reader, const std::filesystem::path& mesh);

/// Reads, decodes and validates one (node, LOD). An LOD without triangles gives an empty mesh.
/// @throws Error kIo, kFormat or kLimit, naming file and node. Thread safe.
Mesh readLod(const Reader& reader, const Node& node, uint32_t lod);

/// Joins a cut into one mesh. Merges vertices with equal position and attributes; vertices are numbered by
/// first use.
/// @throws Error as readLod; kLimit if the vertices exceed 32-bit indices. Thread safe.
Mesh assembleCut(const Reader& reader, const Cut& cut);

/// Writes a cut in the format of the path's extension (writeMesh()), and its textures next to it
/// (exportTextures()). @throws Error as these.
void exportCut(const Reader& reader, const Cut& cut, const std::filesystem::path& path);

}  // namespace lode::store
