#pragma once

#include <filesystem>

#include "common/io/image_files.h"
#include "common/mesh.h"
#include "server/store/cut.h"
#include "server/store/reader.h"

namespace lode::store {

/// Writes the images of a store's textures, at full size and without further loss, as PNG files beside a
/// mesh's file: STEM_NAME.png, where STEM is that file's and NAME the texture's without folders. Memory: one
/// row of tiles.
/// @throws Error kIo, kFormat, kLimit.
ImageFiles exportTextures(const Reader& reader, const std::filesystem::path& mesh);

/// Reads and decodes one (node, LOD) with all guards. An LOD without triangles gives an empty mesh.
/// @throws Error kIo, kFormat or kLimit, naming file and node. Thread safe.
Mesh readLod(const Reader& reader, const Node& node, uint32_t lod);

/// Puts a cut together into one mesh; vertices equal in position and attributes become one, in the order of
/// their first use.
/// @throws Error as readLod; kLimit if the vertices exceed 32-bit indices. Thread safe.
Mesh assembleCut(const Reader& reader, const Cut& cut);

/// Writes a cut in the format that the path asks for (writeMesh()), and its images beside it
/// (exportTextures()). @throws Error as these.
void exportCut(const Reader& reader, const Cut& cut, const std::filesystem::path& path);

}  // namespace lode::store
