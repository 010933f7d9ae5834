#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/measure/rung_input.h"
#include "server/ingest/measure/rung_surface.h"
#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/simplified_mesh.h"

namespace lode::ingest {

/// What a rung is measured with; see placesOn(), sourcesOf().
struct RungPlaces {
  const RungSurface& surface;
  std::span<const SurfaceWalk::Place> of_input;
  std::span<const uint32_t> sources;
};

/// How far a rung and the original are from each other, lattice steps, rather too much than too little: by
/// the distance between the rung and what it was made of, both ways, and where that is not the original
/// itself, by samples of the original and by what it is off by, added as an independent error. (Sums instead
/// would be 2 to 5 times too large.)
/// @param farthest_sample  from the rung.
float rungDeviation(const SimplifiedMesh& rung, const RungInput& input, const RungPlaces& places,
                    float farthest_sample);

}  // namespace lode::ingest
