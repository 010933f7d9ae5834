#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/mesh.h"

namespace lode::ingest {

struct SampleOptions {
  std::string kind;         ///< "asteroid"
  uint64_t triangles = 0;   ///< at most this many; up to 4e9
  AttributeSet attributes;  ///< normals, colours on request
  uint64_t seed = 1;
};

/// Streams a closed procedural mesh to a binary PLY in constant memory; the file appears under its name when
/// complete.
/// @return triangles written: the largest count that the kind can make that is <= options.triangles.
/// @throws Error kUsage (unknown kind, too few triangles), kIo.
uint64_t writeSample(const SampleOptions& options, const std::filesystem::path& path);

}  // namespace lode::ingest
