#pragma once

#include <filesystem>

#include "common/io/mesh_materials.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Returns the path of an OBJ file's material file: STEM.mtl beside it.
std::filesystem::path materialFileOf(const std::filesystem::path& obj);

/// Writes a mesh as Wavefront OBJ in true coordinates. Colours follow the coordinates of a vertex as three
/// numbers from 0 to 1, as most programs expect; alpha is omitted. The file STEM.mtl beside the OBJ file
/// names the images and alpha maps of the materials.
/// @return true if STEM.mtl is written. @throws Error kIo. @see writeMesh().
bool writeObj(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
              const ImageFiles& images = {});

}  // namespace lode
