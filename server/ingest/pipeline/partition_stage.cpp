#include "server/ingest/pipeline/partition_stage.h"

#include <memory>

namespace lode::ingest {

PartitionStage::PartitionStage(BuildSession& session, DereferenceStage& dereference)
    : Stage({.name = "partition",
             .entry = BuildEntry::kPartitioned,
             .used_up_by = BuildEntry::kSimplified,
             .files = {Partition::kLeafFile, BorderTable::kFile}}),
      session_(session),
      dereference_(dereference) {}

Stage::Work PartitionStage::run() {
  const std::unique_ptr<RecordSorter> sorted = dereference_.takeSorted();
  const BuildOptions& options = session_.options();
  const MemoryPlan& plan = session_.plan();
  partition_.emplace(ingest::partition(*sorted, session_.facts().soup_attributes, options.triangles_per_node,
                                       CreaseAngle(options.crease_angle_deg), plan.sort_bytes, plan.threads,
                                       session_.files(), session_.progress()));
  return {partition_->triangles, partition_->meshes.size() + partition_->border.temporaryBytes()};
}

void PartitionStage::load(RecordReader& record, bool is_used_up) {
  if (!is_used_up)
    partition_.emplace(Partition::load(session_.files(), session_.facts().soup_attributes, record));
}

}  // namespace lode::ingest
