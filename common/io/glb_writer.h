#pragma once

#include <filesystem>

#include "common/io/mesh_materials.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Writes a mesh as binary glTF 2.0 (Khronos, 2021): positions as floats beside the lattice's origin, which
/// is the node's translation, so that both are exact; colours made linear, as that format has them; a
/// primitive and a material for each material of the mesh, with the image that it wears named, not held. What
/// an image's clear texels hide is cut out; vertices that are not opaque blend. Axes are the file's own.
/// @throws Error kIo; kLimit if the file would exceed 4 GB or the lattice's step the range of floats.
/// @see writeMesh().
void writeGlb(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
              const ImageFiles& images = {});

}  // namespace lode
