#pragma once

#include <string>
#include <vector>

#include "server/ingest/plan/build_options.h"
#include "server/ingest/soup/input_images.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

struct ScannedModel {
  PackedInput input;
  PlyCounts counts;
  std::vector<NamedImage> images;  ///< images that the headers name
};

/// Returns true if the file's positions need double precision.
bool hasDoublePositions(const PlyHeader& header);

/// Returns the attributes that a build uses from a file. Omits normals if all have length zero.
AttributeSet takenAttributes(AttributeSet attributes, const PlyCounts& counts) noexcept;

/// Reads and packs the input files, one after another. Reads them twice if all normals have length zero.
/// @throws Error as PlyReader does; kInput also if no face is usable, or if the attributes of files differ;
/// kLimit if the files have more vertices together than 32-bit indices can number.
ScannedModel scan(const BuildOptions& options, const TemporaryFolder& folder, const BuildProgress& progress,
                  std::vector<std::string>& warnings);

}  // namespace lode::ingest
