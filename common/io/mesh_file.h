#pragma once

#include <filesystem>

#include "common/io/mesh_materials.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Formats in which meshes are written.
enum class MeshFormat { kPly, kObj, kGlb };

/// What a file's name asks for by its ending: .ply, .obj or .glb in either case. PLY for no name at all, and
/// where a pipe, a device or the standard output has no ending.
/// @throws Error kUsage for another ending or none, naming those that there are, and as findOutput().
MeshFormat meshFormatOf(const std::filesystem::path& path);

/// Writes a mesh in the format that the name asks for, in true coordinates, with its attributes as far as the
/// format has them, to a temporary file that is renamed at the end.
/// @param images  what the mesh's texture coordinates mean, and the image files, which are named in the file.
/// @throws Error kUsage as meshFormatOf(), kIo, kLimit; kInternal if the mesh lacks attributes of its
/// vertices.
void writeMesh(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
               const ImageFiles& images = {});

}  // namespace lode
