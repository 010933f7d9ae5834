#pragma once

#include <optional>

#include "server/ingest/nodes/treelet_folder.h"
#include "server/ingest/nodes/treelet_plan.h"
#include "server/ingest/plan/build_options.h"

/// Builds in parts, for several machines with a common file system; see docs/cluster.md. `prepare` writes the
/// partition, each task builds treelets from it, and `finish` builds the treelets near the root and the
/// store.
namespace lode::ingest {

/// Returns the summary of the store if nothing is prepared, but the store is less than an hour old and newer
/// than the inputs: a scheduler may run `finish` again after it has succeeded on a machine that is lost
/// since.
/// @throws Error if the file at the output's path is no readable store.
std::optional<ModelSummary> finishedBefore(const BuildOptions& options);

/// Checks that the output was prepared for parts with the same input and options.
/// @param options  options with all defaults filled in. @throws Error kIo if the preparation is missing or
/// incomplete, kInput if it belongs to another build, kFormat.
void requirePrepared(const BuildOptions& options);

/// Builds the treelets of one task. Takes over treelets that the same task finished before. Several processes
/// can run the same task at the same time. @throws Error.
BuildReport runTask(const BuildOptions& options, const BuildProgress& progress);

/// @throws Error kIo if a treelet of a task is not finished.
void requireAllTasks(const BuildOptions& options, const TreeletPlan& treelets, const TreeletFolder& folder);

}  // namespace lode::ingest
