#pragma once

#include <filesystem>

#include "common/codec/texture_set.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Writes a mesh as binary little-endian PLY in true coordinates (double where the lattice needs it, else
/// float), with its attributes, to a temporary file that is renamed at the end.
/// @param textures  what the mesh's texture coordinates mean, and the names of the image files, one comment
///                  TextureFile each.
/// @throws Error kIo. @see writeMesh().
void writePly(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
              const TextureSet& textures = {});

}  // namespace lode
