#pragma once

#include <optional>

#include "server/ingest/nodes/node_builder.h"
#include "server/ingest/nodes/node_spool.h"
#include "server/ingest/pipeline/build_session.h"
#include "server/ingest/pipeline/partition_stage.h"

namespace lode::ingest {

/// Makes all nodes with their LODs, measured and encoded.
class SimplifyStage final : public Stage {
 public:
  SimplifyStage(BuildSession& session, PartitionStage& partition);

  Work run() override;
  void save(RecordWriter& /*record*/) const override {}
  void load(RecordReader& record, bool is_used_up) override;

  NodeSpool& nodes() noexcept { return *nodes_; }
  const PayloadSpool& payloads() const noexcept { return *payloads_; }

 private:
  NodeBuilder::Settings settings() const;
  void warnOfSmallMemory();

  BuildSession& session_;
  PartitionStage& partition_;
  std::optional<PayloadSpool> payloads_;
  std::optional<NodeSpool> nodes_;
};

}  // namespace lode::ingest
