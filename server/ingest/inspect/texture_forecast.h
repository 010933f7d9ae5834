#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/textures/texture_images.h"

namespace lode::ingest {

/// Cost of the build stage "textures".
struct TextureForecast {
  double serial_cpu_seconds = 0;    ///< CPU time of reading, decoding and halving images on one thread
  double parallel_cpu_seconds = 0;  ///< CPU time of encoding tiles on all threads
  /// Size of the encoded tiles, in the temporary file and later in the store.
  uint64_t tile_bytes = 0;
  uint64_t memory_bytes = 0;  ///< peak memory, not counting the program itself
};

/// Forecasts the cost of textures on this machine under its current load. Decodes all images, or an evenly
/// spread selection if they have too many texels in total. Encodes a few tiles of each decoded image, and
/// scales the measured cost. Keeps one image in memory at a time. Thread safe.
/// @param images   the model's images; an image with a problem costs nothing.
/// @param threads  number of threads of the build.
TextureForecast forecastTextures(std::span<const TextureImage> images, uint64_t memory_bytes,
                                 unsigned threads);

}  // namespace lode::ingest
