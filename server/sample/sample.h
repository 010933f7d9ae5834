#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/mesh.h"

namespace lode::ingest {

struct SampleOptions {
  std::string kind;         ///< "asteroid", "gyroid" or "terrain"
  uint64_t triangles = 0;   ///< at most this many; up to 4e9
  AttributeSet attributes;  ///< normals, colours, texture coordinates on request
  uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: as many as the machine has; the file is the same for any number
};

/// Streams a procedural mesh to a binary PLY in memory that does not grow with it; the file appears under its
/// name when complete. What the kinds look like stands in asteroid.h, gyroid.h and terrain.h.
/// @return triangles written: the largest count that the kind can make that is <= options.triangles.
/// @throws Error kUsage (unknown kind or attribute, too few or too many triangles), kIo.
uint64_t writeSample(const SampleOptions& options, const std::filesystem::path& path);

}  // namespace lode::ingest
