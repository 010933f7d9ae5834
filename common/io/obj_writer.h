#pragma once

#include <filesystem>

#include "common/io/mesh_materials.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Writes a mesh as Wavefront OBJ in true coordinates. Colours follow the coordinates of a vertex as three
/// numbers from 0 to 1, as most programs expect; alpha is omitted. The file STEM.mtl beside the OBJ file
/// names the images and alpha maps of the materials. @throws Error kIo. @see writeMesh().
void writeObj(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
              const ImageFiles& images = {});

}  // namespace lode
