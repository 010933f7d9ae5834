#pragma once

#include <cstdint>
#include <vector>

#include "server/ingest/nodes/treelet_plan.h"

namespace lode::ingest {

/// Distributes the treelets of a model among tasks of similar size. The result depends on the treelets and on
/// the number of tasks alone, so that all processes of a build agree on it.
/// @return for each treelet the number of its task, or `tasks` for the treelets near the root, which need the
/// results of several tasks.
std::vector<uint32_t> planTasks(const TreeletPlan& treelets, uint32_t tasks);

}  // namespace lode::ingest
