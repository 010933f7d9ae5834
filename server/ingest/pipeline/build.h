#pragma once

#include <string>
#include <vector>

#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// Builds a store from a PLY file. The store gets its final name only when it is complete. A journal records
/// finished work (see BuildFolder); a killed build resumes from it. A build that fails removes all its files,
/// unless `resume` is set. Only one process at a time can build a given output.
/// @throws Error kUsage (bad output or --triangles-per-node), kInput (also if input or options differ from
/// those of the build to resume), kIo, kLimit, kFormat (if files of the build to resume are damaged).
BuildReport build(const BuildOptions& options, const BuildProgress& progress = {});

/// Writes only options.preview. @throws Error as scan() does; kIo; kLimit if the preview needs more memory.
void buildPreview(const BuildOptions& options, std::vector<std::string>& warnings,
                  const BuildProgress& progress = {});

}  // namespace lode::ingest
