#pragma once

#include <optional>
#include <utility>

#include "server/ingest/partition/partition.h"
#include "server/ingest/pipeline/build_session.h"
#include "server/ingest/pipeline/dereference_stage.h"

namespace lode::ingest {

/// Cuts the sorted triangles into leaves, welds these, and finds what they share.
class PartitionStage final : public Stage {
 public:
  PartitionStage(BuildSession& session, DereferenceStage& dereference);

  Work run() override;
  void save(RecordWriter& record) const override { partition_->save(record); }
  void load(RecordReader& record, bool is_used_up) override;

  const Partition& partition() const noexcept { return *partition_; }
  void release() noexcept { partition_.reset(); }

 private:
  BuildSession& session_;
  DereferenceStage& dereference_;
  std::optional<Partition> partition_;
};

}  // namespace lode::ingest
