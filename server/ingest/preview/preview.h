#pragma once

#include <filesystem>

#include "server/ingest/preview/texture_colours.h"
#include "server/ingest/soup/lattice_choice.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

/// Returns the memory that writePreview() needs for an input.
uint64_t previewBytes(const PackedInput& input) noexcept;

/// Writes a store of one node with one LOD, which shows the whole model before the build is finished. The
/// store is on the lattice of the finished store, so that a server can replace it by the finished store while
/// clients view it. The error of the LOD is an upper bound. The mesh has colours in place of textures.
/// @return false, and writes nothing, if every triangle has two corners at one lattice point. @throws Error
/// kIo.
bool writePreview(const std::filesystem::path& path, const PackedInput& input, const LatticeChoice& choice,
                  const TextureColours& textures = {});

}  // namespace lode::ingest
