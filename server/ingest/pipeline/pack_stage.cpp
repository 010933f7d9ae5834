#include "server/ingest/pipeline/pack_stage.h"

#include <utility>

#include "server/ingest/pipeline/pack.h"
#include "server/store/writer.h"

namespace lode::ingest {

PackStage::PackStage(BuildSession& session, const TextureStage& textures, SimplifyStage& simplified)
    : Stage({.name = "pack", .entry = BuildEntry::kPacked, .used_up_by = BuildEntry::kPacked}),
      session_(session),
      textures_(textures),
      simplified_(simplified) {}

ModelSummary PackStage::description() const {
  const BuildFacts& facts = session_.facts();
  ModelSummary summary;
  summary.name = session_.options().output.stem().string();
  summary.lattice = facts.choice.lattice;
  summary.attributes = facts.payloadAttributes();
  summary.triangles = facts.counts.triangles;
  summary.dropped = facts.counts.dropped + facts.dropped_triangles;
  summary.triangles_per_node = session_.options().triangles_per_node;
  return summary;
}

Stage::Work PackStage::run() {
  ModelSummary summary = description();
  store::Writer writer(session_.options().output, session_.store());
  if (summary.attributes.has(AttributeSet::kTexture))
    packTextures(textures_.textures(), session_.facts().uv_grid, textures_.tiles(), writer);
  summary =
      pack(writer, std::move(summary), simplified_.nodes(), simplified_.payloads(), session_.progress());
  build_id_ = summary.build_id;
  const uint64_t payloads = summary.payloads;
  session_.setSummary(std::move(summary));
  return {payloads, 0};
}

}  // namespace lode::ingest
