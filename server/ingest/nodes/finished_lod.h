#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/codec/draco_codec.h"
#include "server/ingest/measure/lod_input.h"
#include "server/ingest/measure/surface_samples.h"
#include "server/ingest/mesh/simplified_mesh.h"
#include "server/ingest/partition/normal_fans.h"

namespace lode::ingest {

/// An LOD, encoded and measured against what it was made of, and its boundaries against the original's;
/// lengths are in lattice steps.
struct FinishedLod {
  SimplifiedMesh simplified;
  EncodedPayload payload;
  std::vector<Deviation> deviations;      ///< of the samples; see deviationsFrom()
  float deviation_steps = 0;              ///< see lodDeviation()
  std::optional<SurfaceSample> farthest;  ///< see LodDeviation, but near a position of the LOD
  float boundary_gap_steps = 0;           ///< see boundaryGap()
  float lost_detail_steps = 0;            ///< see lostDetail()
};

/// Gives a simplified mesh its computed normals, where they are not the file's, measures and encodes it.
/// @param samples  near positions of the input. @param step_model  the lattice's. Thread safe.
FinishedLod finishLod(SimplifiedMesh&& simplified, const LodInput& input,
                      std::span<const SurfaceSample> samples, double step_model, const CreaseAngle& crease,
                      MeshSource source);

}  // namespace lode::ingest
