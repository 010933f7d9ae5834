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

/// Whether the file's positions need more than float.
bool hasDoublePositions(const PlyHeader& header);

/// Of a file's attributes, those that a build takes: no normals where none of them has a length.
AttributeSet takenAttributes(AttributeSet attributes, const PlyCounts& counts) noexcept;

/// Stage 1: reads the PLY file once and packs it; twice, if none of its normals has a length.
/// @throws Error as PlyReader; kInput also if no face is usable.
ScannedModel scan(const BuildOptions& options, const TemporaryFolder& folder, const BuildProgress& progress,
                  std::vector<std::string>& warnings);

}  // namespace lode::ingest
