#include "server/ingest/nodes/finished_lod.h"

#include <algorithm>
#include <utility>

#include "server/ingest/measure/boundary_gap.h"
#include "server/ingest/measure/lod_deviation.h"
#include "server/ingest/measure/lost_detail.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/nodes/computed_normals.h"

namespace lode::ingest {

FinishedLod finishLod(SimplifiedMesh&& simplified, const LodInput& input,
                      std::span<const SurfaceSample> samples, double step_model, const CreaseAngle& crease,
                      MeshSource source) {
  FinishedLod finished;
  finished.simplified = std::move(simplified);
  SimplifiedMesh& lod = finished.simplified;
  const std::vector<uint32_t> sources = sourcesOf(lod, input.mesh());
  const LodSurface surface(lod.mesh);
  const std::vector<SurfaceWalk::Place> places = placesOn(lod, input.mesh(), surface.walk());
  giveComputedNormals(lod, input.mesh(), sources, places, crease);
  finished.payload = encodePayload(toMesh(lod.mesh), step_model, source);
  if (lod.mesh.triangles.empty()) return finished;
  finished.deviations = deviationsFrom(lod, input.mesh(), surface, places, samples);
  float sampled = 0;
  for (const Deviation& deviation : finished.deviations) sampled = std::max(sampled, deviation.steps);
  const LodDeviation deviation = lodDeviation(lod, input, {surface, places, sources}, sampled);
  finished.deviation_steps = deviation.steps;
  finished.farthest = deviation.farthest;
  if (finished.farthest) finished.farthest->near = lod.became[finished.farthest->near];
  finished.boundary_gap_steps = boundaryGap(lod, input);
  finished.lost_detail_steps = lostDetail(lod, input.mesh(), places);
  return finished;
}

}  // namespace lode::ingest
