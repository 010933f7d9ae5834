#pragma once

#include <cstddef>
#include <vector>

#include "server/ingest/node_mesh.h"
#include "server/ingest/triangle_grid.h"

namespace lode::ingest {

/// A point of the original surface that travels up the tree, with the largest deviation from it that any rung
/// on the way had, in lattice steps.
struct SurfaceSample {
  PositionCode position;
  float deviation = 0;
};

/// The vertices of a leaf as samples.
std::vector<SurfaceSample> samplesOf(const NodeMesh& leaf);

/// Keeps at most `capacity` samples: half of them those with the largest deviations, the others those with
/// the lowest hash of position, an unbiased choice that does not depend on the order. A position counts once.
void selectSamples(std::vector<SurfaceSample>& samples, size_t capacity);

/// Measures the samples against a rung and raises their deviations. @return the largest distance, lattice
/// steps.
float measureDeviation(const NodeMesh& rung, std::vector<SurfaceSample>& samples);

/// The largest distance of a rung's vertices from the mesh it was made of, lattice steps.
float farthestVertex(const NodeMesh& rung, const TriangleGrid& input);

}  // namespace lode::ingest
