#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/mesh.h"

namespace lode::ingest {

struct SampleOptions {
  std::string kind;         ///< "asteroid"
  uint64_t triangles = 0;   ///< at most this many; up to 4e9
  AttributeSet attributes;  ///< normals, colours, texture coordinates on request
  uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: as many as the machine has; the file is the same for any number
};

/// Streams a closed procedural mesh to a binary PLY in constant memory; the file appears under its name when
/// complete. The asteroid is a cube of n x n squares a side, blown up to a ball of radius about 1 with relief
/// of all sizes down to the triangles'; a mesh of more triangles shows the same relief in more detail.
/// @return triangles written: the largest count that the kind can make that is <= options.triangles.
/// @throws Error kUsage (unknown kind, too few triangles), kIo.
uint64_t writeSample(const SampleOptions& options, const std::filesystem::path& path);

}  // namespace lode::ingest
