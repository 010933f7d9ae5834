#include "server/ingest/pipeline/treelets_of_build.h"

#include <algorithm>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/soup/former_lattice.h"

namespace lode::ingest {
namespace {

NodeBuilder::Settings settingsOf(const BuildFacts& facts, const BuildOptions& options) {
  return {facts.choice.lattice,
          facts.choice.extent,
          facts.payloadAttributes(),
          options.triangles_per_node,
          options.simplifier,
          std::max(facts.choice.least_snap_error_steps, errorOfSnapping(facts.counts.snap_error_steps)),
          CreaseAngle(options.crease_angle_deg)};
}

/// Computes the digest of all that determines the nodes of given leaves: the program and the settings.
Digest digestOf(const NodeBuilder::Settings& settings, float crease_angle_deg) {
  // Name all members, so that this code does not compile after a member is added.
  const auto& [lattice, extent, attributes, triangles_per_node, simplifier, snap_error_steps, crease] =
      settings;
  RecordWriter record;
  record.put(programContent());
  record.put(lattice.origin);
  record.put(lattice.step);
  record.put(extent);
  record.put(attributes);
  record.put(triangles_per_node);
  record.put(simplifier);
  record.put(snap_error_steps);
  record.put(crease_angle_deg);
  return lode::digestOf(record.bytes());
}

std::vector<LeafOfTreelet> leavesOf(const Partition& partition) {
  std::vector<LeafOfTreelet> leaves;
  leaves.reserve(partition.leaves.size());
  for (uint32_t leaf = 0; leaf < partition.leaves.size(); ++leaf) {
    RecordWriter record;
    record.put(partition.digests[leaf]);
    record.put(partition.border.digest(leaf));
    leaves.push_back({lode::digestOf(record.bytes()), partition.begin[leaf + 1] - partition.begin[leaf]});
  }
  return leaves;
}

}  // namespace

TreeletsOfBuild::TreeletsOfBuild(const BuildFacts& facts, const BuildOptions& options,
                                 const Partition& partition)
    : settings(settingsOf(facts, options)),
      tree(partition.leaves),
      treelets(tree, leavesOf(partition), digestOf(settings, options.crease_angle_deg)) {}

}  // namespace lode::ingest
