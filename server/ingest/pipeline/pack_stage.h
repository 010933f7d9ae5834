#pragma once

#include "common/codec/model_summary.h"
#include "server/ingest/pipeline/build_session.h"
#include "server/ingest/pipeline/simplify_stage.h"
#include "server/ingest/pipeline/texture_stage.h"

namespace lode::ingest {

/// Writes the store and gives it its name.
class PackStage final : public Stage {
 public:
  PackStage(BuildSession& session, const TextureStage& textures, SimplifyStage& simplified);

  Work run() override;
  void save(RecordWriter& record) const override { record.put(build_id_); }
  /// BuildSession has compared the store with it.
  void load(RecordReader& /*record*/, bool /*is_used_up*/) override {}

 private:
  ModelSummary description() const;

  BuildSession& session_;
  const TextureStage& textures_;
  SimplifyStage& simplified_;
  Digest build_id_;
};

}  // namespace lode::ingest
