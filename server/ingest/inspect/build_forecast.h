#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/mesh.h"
#include "server/ingest/textures/texture_images.h"

namespace lode::ingest {

/// What a build counts on; enough to say what it will cost.
struct ForecastInput {
  std::filesystem::path model;  ///< a PLY that can be read
  uint64_t vertices = 0, faces = 0, triangles = 0;
  AttributeSet attributes;           ///< of the file
  bool double_positions = false;     ///< positions need more than float
  bool corner_texture = false;       ///< texture coordinates come with the faces' corners
  double scan_cpu_seconds = 0;       ///< that reading the file took
  std::vector<TextureImage> images;  ///< that a build takes, if the model has texture coordinates
  uint64_t memory_bytes = 0;         ///< budget
  unsigned threads = 1;
  std::filesystem::path temporary_folder;  ///< for the trial; nothing stays there
};

struct BuildForecast {
  double seconds = 0, cpu_seconds = 0;
  uint64_t memory_bytes = 0;     ///< peak, resident
  uint64_t temporary_bytes = 0;  ///< on disk at once, besides the store
  uint64_t store_bytes = 0;
};

/// Builds a part of the model, the whole of a small one, and encodes some of the texture images' tiles, here
/// and now, and scales up what that took: a forecast for this machine as it is loaded now. Of a model whose
/// faces lie in the file without order a sample with the same attributes is built instead.
/// @throws Error kIo if there is no place for the part.
BuildForecast forecastBuild(const ForecastInput& input);

}  // namespace lode::ingest
