#pragma once

#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// Builds a store from a PLY file. The store gets its name when it is complete. A journal records finished
/// work (see BuildFolder), so that a killed build can be resumed; a build that fails otherwise leaves nothing
/// behind unless `resume` is set. Only one process can build an output at a time.
/// @throws Error kInput (also: input or options differ from those of the build to resume), kIo, kLimit,
/// kFormat (the files of the build to resume are damaged).
BuildReport build(const BuildOptions& options, const BuildProgress& progress = {});

}  // namespace lode::ingest
