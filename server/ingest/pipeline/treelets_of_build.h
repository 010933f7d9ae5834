#pragma once

#include <string_view>
#include <vector>

#include "server/ingest/nodes/node_builder.h"
#include "server/ingest/nodes/treelet_plan.h"
#include "server/ingest/partition/partition.h"
#include "server/ingest/pipeline/recorded_build.h"
#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// Folder of a build's finished treelets, among its temporary files.
constexpr std::string_view kTreeletFolder = "treelets";

/// The octree of a partitioned model, its treelets, and the settings of its nodes. The same for all processes
/// that build parts of a model.
struct TreeletsOfBuild {
  NodeBuilder::Settings settings;
  TreePlan tree;
  TreeletPlan treelets;

  TreeletsOfBuild(const BuildFacts& facts, const BuildOptions& options, const Partition& partition);
  TreeletsOfBuild(const TreeletsOfBuild&) = delete;
  TreeletsOfBuild& operator=(const TreeletsOfBuild&) = delete;
};

}  // namespace lode::ingest
