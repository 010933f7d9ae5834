#pragma once

#include <filesystem>

#include "common/io/mesh_materials.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Formats of mesh files.
enum class MeshFormat { kPly, kObj, kGlb };

/// Returns the format of a file name's ending: .ply, .obj or .glb, in either case. Returns
/// kPly for an empty name, and for a pipe or device without an ending.
/// @throws Error kUsage, which lists the endings, for any other name; also the errors of findOutput().
MeshFormat meshFormatOf(const std::filesystem::path& path);

/// Writes a mesh in the format of the file name, in true coordinates, with the attributes that the format
/// supports, as an AtomicFile.
/// @param images  mapping of texture coordinates, and the image files that the mesh file references.
/// @throws Error kUsage as meshFormatOf(), kIo, kLimit; kInternal if the mesh lacks attributes of its
/// vertices.
void writeMesh(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
               const ImageFiles& images = {});

}  // namespace lode
