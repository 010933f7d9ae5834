#include "server/ingest/build/simplify_stage.h"

#include <string>
#include <utility>

#include "server/ingest/nodes/simplify_log.h"
#include "server/ingest/nodes/tree_builder.h"

namespace lode::ingest {
namespace {

constexpr double kRounding = 1.0001;  ///< of an error that is noted as a float

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
  const uint64_t minimum_bytes = session_.plan().minimum_bytes;
  if (partition_.partition().leaves.size() == 1 || session_.options().memory_bytes >= minimum_bytes) return;
  session_.warn("--memory is less than " + std::to_string(minimum_bytes) + " bytes, which " +
                std::to_string(session_.options().triangles_per_node) +
                " triangles a node take; the build may use more");
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
