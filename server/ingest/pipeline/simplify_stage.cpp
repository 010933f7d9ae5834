#include "server/ingest/pipeline/simplify_stage.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "server/ingest/nodes/lod_targets.h"
#include "server/ingest/nodes/simplify_log.h"
#include "server/ingest/nodes/tree_builder.h"

namespace lode::ingest {
namespace {

constexpr double kRounding = 1.0001;  ///< of an error that is noted as a float

/// What the root's children leave it at most: the longer their borders are, the more.
uint64_t mostTrianglesOfRoot(const Partition& partition, uint32_t triangles_per_node) {
  std::array<bool, 8> has_leaves{};
  for (const NodeKey leaf : partition.leaves) has_leaves[leaf.ancestorAt(1).octant()] = true;
  uint64_t triangles = 0;
  for (size_t octant = 0; octant < has_leaves.size(); ++octant) {
    if (!has_leaves[octant]) continue;
    triangles += mostTriangles({.depth = 1,
                                .locked = partition.border.lockedBelowRoot()[octant],
                                .original_triangles = partition.triangles,
                                .triangles_per_node = triangles_per_node});
  }
  return std::min(triangles, partition.triangles);
}

}  // namespace

SimplifyStage::SimplifyStage(BuildSession& session, PartitionStage& partition)
    : Stage({.name = "simplify",
             .entry = BuildEntry::kSimplified,
             .used_up_by = BuildEntry::kPacked,
             .files = {PayloadSpool::kFile, NodeSpool::kFile}}),
      session_(session),
      partition_(partition) {}

NodeBuilder::Settings SimplifyStage::settings() const {
  const BuildFacts& facts = session_.facts();
  const BuildOptions& options = session_.options();
  return {facts.choice.lattice,
          facts.choice.extent,
          facts.payloadAttributes(),
          options.triangles_per_node,
          options.simplifier,
          static_cast<float>(kRounding * facts.counts.snap_error_steps),
          CreaseAngle(options.crease_angle_deg)};
}

void SimplifyStage::warnOfSmallMemory() {
  const BuildOptions& options = session_.options();
  const Partition& partition = partition_.partition();
  const bool is_one_node = partition.leaves.size() == 1;
  const std::string words = smallBudgetInWords(options.memory_bytes, options.triangles_per_node, is_one_node);
  if (!words.empty()) return session_.warn(words);
  if (is_one_node) return;
  const uint64_t root = mostTrianglesOfRoot(partition, options.triangles_per_node);
  const uint64_t root_bytes = memoryForLargeNode(root, session_.facts().payloadAttributes());
  if (options.memory_bytes < root_bytes)
    session_.warn(budgetBelowInWords(
        root_bytes, "the up to " + std::to_string(root) + " triangles that the root is made of take"));
}

/// Nodes that a killed build had finished are not made again.
Stage::Work SimplifyStage::run() {
  warnOfSmallMemory();
  FinishedNodes finished = std::exchange(session_.recorded().finished, {});
  nodes_.emplace(session_.files().file(NodeSpool::kFile));
  if (finished.nodes.empty()) {
    payloads_.emplace(session_.files());
  } else {
    payloads_.emplace(session_.files(), finished.payload_bytes);
  }
  SimplifyLog log(session_.files(), *payloads_, std::move(finished),
                  [&](std::span<const std::byte> entry) { session_.note(BuildEntry::kNodes, entry); });
  buildTree(settings(), partition_.partition(), *payloads_, session_.files(), log, *nodes_,
            {session_.plan().threads, session_.plan().node_bytes}, session_.progress());
  partition_.release();
  return {nodes_->size(), payloads_->size()};
}

void SimplifyStage::load(RecordReader& /*record*/, bool is_used_up) {
  const FinishedNodes finished = std::exchange(session_.recorded().finished, {});
  if (is_used_up) return;
  nodes_.emplace(session_.files().file(NodeSpool::kFile));
  payloads_.emplace(session_.files(), finished.payload_bytes);
  for (const FinishedNode& node : finished.nodes) nodes_->append(node.node, node.payloads);
}

}  // namespace lode::ingest
