#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/mesh.h"
#include "server/ingest/textures/texture_images.h"

namespace lode::ingest {

/// Properties of a model and a build that determine its cost.
struct ForecastInput {
  std::filesystem::path model;  ///< a readable PLY file
  uint64_t vertices = 0, faces = 0, triangles = 0;
  AttributeSet attributes;        ///< attributes that the file has
  bool double_positions = false;  ///< true if floats are not precise enough for the positions
  AttributeSet face_attributes;   ///< attributes that belong to faces or corners, not to vertices
  double scan_cpu_seconds = 0;    ///< CPU time of reading the file
  /// Images that a build would use; empty if the model has no texture coordinates.
  std::vector<TextureImage> images;
  uint64_t memory_bytes = 0;  ///< memory budget
  unsigned threads = 1;
  std::filesystem::path temporary_folder;  ///< folder for the trial build, which removes its files
};

struct BuildForecast {
  double seconds = 0, cpu_seconds = 0;
  uint64_t memory_bytes = 0;     ///< peak resident memory
  uint64_t temporary_bytes = 0;  ///< peak size of temporary files, not counting the store
  uint64_t store_bytes = 0;
};

/// Forecasts the cost of a build on this machine under its current load. Builds a trial model, encodes some
/// texture tiles, and scales the measured cost. The trial model is a part of the model, or all of it if it is
/// small. If the file lists its faces in no spatial order, the trial model is a sample with the same
/// attributes instead. @throws Error kIo if the disk has no space for the trial model.
BuildForecast forecastBuild(const ForecastInput& input);

}  // namespace lode::ingest
