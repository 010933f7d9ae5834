#pragma once

#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// PLY to store: scan, dereference, partition, simplify (encoding as it goes), pack.
/// The store appears under its name when complete. What is finished is noted in a journal, so that a build
/// that was killed can be resumed (see BuildFolder); on any other failure nothing stays behind, unless
/// `resume` was given. Only one build of an output can run at a time.
/// @throws Error kInput (also: cannot be resumed, since input or options are others), kIo, kLimit, kFormat
/// (what a killed build left is damaged).
BuildReport build(const BuildOptions& options, const BuildProgress& progress = {});

}  // namespace lode::ingest
