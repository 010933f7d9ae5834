#pragma once

#include <string>
#include <vector>

#include "server/ingest/plan/build_options.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

struct ScannedModel {
  PackedInput input;
  PlyCounts counts;
  std::vector<std::string> texture_files;  ///< as the header names them
};

/// Returns whether the file's positions need double.
bool hasDoublePositions(const PlyHeader& header);

/// Attributes that a build takes from a file: without normals if none has a length.
AttributeSet takenAttributes(AttributeSet attributes, const PlyCounts& counts) noexcept;

/// Reads and packs a PLY file; reads it twice if none of its normals has a length.
/// @throws Error as PlyReader; kInput also if no face is usable.
ScannedModel scan(const BuildOptions& options, const TemporaryFolder& folder, const BuildProgress& progress,
                  std::vector<std::string>& warnings);

}  // namespace lode::ingest
