#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/io/mesh_materials.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Formats of mesh files.
enum class MeshFormat { kPly, kObj, kGlb };

/// Returns the format for a file name's ending: .ply, .obj or .glb, in upper or lower case. Returns kPly for
/// an empty name, and for a pipe or device without an ending.
/// @throws Error kUsage, which lists the endings, for any other name; also the errors of findOutput().
MeshFormat meshFormatOf(const std::filesystem::path& path);

/// Writes a mesh through an AtomicFile, in the format of meshFormatOf(path). The file has true coordinates
/// and the attributes that the format supports.
/// @param images  mapping of texture coordinates, and the image files that the mesh file references.
/// @return the files beside the mesh file: its images and its material file.
/// @throws the errors of meshFormatOf(); Error kIo or kLimit; kInternal if `mesh` declares attributes but has
/// no values for its vertices.
std::vector<std::filesystem::path> writeMesh(const std::filesystem::path& path, const Mesh& mesh,
                                             const Lattice& lattice, const ImageFiles& images = {});

/// Returns a line that lists the files of writeMesh() for the user; an empty text if there are none.
std::string describeFilesBeside(const std::vector<std::filesystem::path>& files);

}  // namespace lode
