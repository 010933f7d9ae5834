#pragma once

#include <filesystem>

#include "common/io/mesh_materials.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Writes a mesh as Wavefront OBJ in true coordinates. Colours follow the coordinates of a vertex, 0 to 1
/// each, as most programs read them; alpha is left out. Where a material wears an image, STEM.mtl beside it
/// says which, and that one with alpha cuts out. @throws Error kIo. @see writeMesh().
void writeObj(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
              const ImageFiles& images = {});

}  // namespace lode
