#pragma once

#include <filesystem>

#include "common/codec/texture_set.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Writes a mesh as binary little-endian PLY in true coordinates (double if the lattice needs it, else
/// float), with its attributes, through an AtomicFile.
/// @param textures  mapping of texture coordinates, and names of image files; the header lists each name in a
/// comment TextureFile.
/// @throws Error kIo. @see writeMesh().
void writePly(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
              const TextureSet& textures = {});

}  // namespace lode
