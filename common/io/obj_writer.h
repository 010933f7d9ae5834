#pragma once

#include <filesystem>

#include "common/io/mesh_materials.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Writes a mesh as Wavefront OBJ in true coordinates. Colours, 0 to 1 each, follow the coordinates of a
/// vertex, as most programs read them; alpha is omitted. STEM.mtl beside the file names the images of
/// materials and the alpha maps. @throws Error kIo. @see writeMesh().
void writeObj(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
              const ImageFiles& images = {});

}  // namespace lode
