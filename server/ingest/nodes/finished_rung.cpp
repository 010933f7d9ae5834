#include "server/ingest/nodes/finished_rung.h"

#include <algorithm>
#include <utility>

#include "server/ingest/measure/lost_detail.h"
#include "server/ingest/measure/rim_gap.h"
#include "server/ingest/measure/rung_deviation.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/nodes/computed_normals.h"

namespace lode::ingest {

FinishedRung finishRung(SimplifiedMesh&& simplified, const RungInput& input,
                        std::span<const SurfaceSample> samples, double step_model, const CreaseAngle& crease,
                        MeshSource source) {
  FinishedRung finished;
  finished.simplified = std::move(simplified);
  SimplifiedMesh& rung = finished.simplified;
  const std::vector<uint32_t> sources = sourcesOf(rung, input.mesh());
  const RungSurface surface(rung.mesh);
  const std::vector<SurfaceWalk::Place> places = placesOn(rung, input.mesh(), surface.walk());
  giveComputedNormals(rung, input.mesh(), sources, places, crease);
  finished.payload = encodePayload(toMesh(rung.mesh), step_model, source);
  if (rung.mesh.triangles.empty()) return finished;
  finished.deviations = deviationsFrom(rung, input.mesh(), surface, places, samples);
  float sampled = 0;
  for (const Deviation& deviation : finished.deviations) sampled = std::max(sampled, deviation.steps);
  const RungDeviation deviation = rungDeviation(rung, input, {surface, places, sources}, sampled);
  finished.deviation_steps = deviation.steps;
  finished.farthest = deviation.farthest;
  if (finished.farthest) finished.farthest->near = rung.became[finished.farthest->near];
  finished.rim_gap_steps = rimGap(rung, input);
  finished.lost_detail_steps = lostDetail(rung, input.mesh(), places);
  return finished;
}

}  // namespace lode::ingest
