#pragma once

#include <string>
#include <vector>

#include "server/ingest/plan/build_options.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

struct ScannedModel {
  PackedInput input;
  PlyCounts counts;
  std::vector<std::string> texture_files;  ///< names of texture files in the header
};

/// Returns true if the file's positions need double precision.
bool hasDoublePositions(const PlyHeader& header);

/// Returns the attributes that a build uses from a file. Omits normals if all have length zero.
AttributeSet takenAttributes(AttributeSet attributes, const PlyCounts& counts) noexcept;

/// Reads and packs a PLY file. Reads the file twice if all its normals have length zero.
/// @throws Error as PlyReader does; kInput also if no face is usable.
ScannedModel scan(const BuildOptions& options, const TemporaryFolder& folder, const BuildProgress& progress,
                  std::vector<std::string>& warnings);

}  // namespace lode::ingest
