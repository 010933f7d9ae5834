#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/textures/texture_images.h"

namespace lode::ingest {

/// Cost of the build stage "textures".
struct TextureForecast {
  double serial_cpu_seconds = 0;    ///< reading, decoding and halving
  double parallel_cpu_seconds = 0;  ///< encoding on all threads
  uint64_t tile_bytes = 0;          ///< in a temporary file, then in the store
  uint64_t memory_bytes = 0;        ///< peak, besides the program
};

/// Forecasts the cost of textures on this machine under its current load: decodes images (all if they are
/// small, else an even selection), encodes a few tiles of each, and scales the measured cost. Holds one image
/// in memory at a time. Thread safe.
/// @param images   images with a problem cost nothing.
/// @param threads  of the build.
TextureForecast forecastTextures(std::span<const TextureImage> images, uint64_t memory_bytes,
                                 unsigned threads);

}  // namespace lode::ingest
