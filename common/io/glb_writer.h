#pragma once

#include <filesystem>

#include "common/io/mesh_materials.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Writes a mesh as binary glTF 2.0 (Khronos, 2021). Positions are floats in the model frame, and the
/// lattice's origin is the node's translation, so both are exact. Colours are linear. Each material of the
/// mesh becomes a primitive with a material that references the image file. The alpha mode is BLEND if
/// vertices have alpha, else MASK if the image has alpha. The file keeps the axes of the model.
/// @throws Error kIo; kLimit if the file would exceed 4 GB, or if the lattice step is too small or too large
/// for exact floats.
/// @see writeMesh().
void writeGlb(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
              const ImageFiles& images = {});

}  // namespace lode
