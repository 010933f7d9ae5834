#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/mesh.h"

namespace lode::ingest {

struct SampleOptions {
  std::string kind;         ///< "asteroid", "gyroid" or "terrain"
  uint64_t triangles = 0;   ///< maximum number of triangles, up to 4e9
  AttributeSet attributes;  ///< any of normals, colours, texture coordinates
  uint64_t seed = 1;
  unsigned threads = 0;  ///< number of threads; 0: one per core; the file does not depend on this number
};

/// Writes a procedural mesh to a binary PLY file, in bounded memory. The file gets its final name only when
/// it is complete. See asteroid.h, gyroid.h and terrain.h for the kinds.
/// @return number of triangles written: the largest number up to options.triangles that the kind allows.
/// @throws Error kUsage (unknown kind or attribute, too few or too many triangles), kIo.
uint64_t writeSample(const SampleOptions& options, const std::filesystem::path& path);

}  // namespace lode::ingest
