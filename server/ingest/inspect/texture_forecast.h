#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/textures/texture_images.h"

namespace lode::ingest {

/// What the stage "textures" will cost.
struct TextureForecast {
  double serial_cpu_seconds = 0;    ///< reading, decoding and halving
  double parallel_cpu_seconds = 0;  ///< encoding, on all threads
  uint64_t tile_bytes = 0;          ///< in a temporary file, and then in the store
  uint64_t memory_bytes = 0;        ///< peak, beside the program
};

/// Decodes images, all of them up to some size and then a spread, encodes a few tiles of each, here and now,
/// and scales up what that took. Takes the memory of one image at a time.
/// @param images   images that have a problem cost nothing.
/// @param threads  of the build. Thread safe.
TextureForecast forecastTextures(std::span<const TextureImage> images, uint64_t memory_bytes,
                                 unsigned threads);

}  // namespace lode::ingest
