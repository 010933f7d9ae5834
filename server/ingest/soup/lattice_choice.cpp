#include "server/ingest/soup/lattice_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "common/error.h"
#include "common/release_storage.h"
#include "server/ingest/mesh/vertex_set.h"
#include "server/ingest/soup/face_batch.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kSampledFaces = 1 << 17;
constexpr double kStepsInShortEdge = 32;
/// Minimum number of lattice steps along the box's longest side. Snapping moves a corner by at most half the
/// diagonal of a lattice cell, or 0.87 steps. If the longest side is 3840 pixels wide on a screen, a corner
/// moves by less than a pixel.
constexpr double kLeastStepsInBox = 4096;
constexpr double kMostStepsInBox = (1 << kLatticeBits) - 2;
constexpr uint64_t kFacesForEachLost = 1'000'000;

/// The vertices that faces use, and an even sample of the faces.
struct UsedAndSampled {
  VertexSet used;
  std::vector<SampledFace> faces;
};

UsedAndSampled sampleFaces(const PackedInput& input) {
  UsedAndSampled result{VertexSet(input.vertexCount()), {}};
  const uint64_t stride = faceStride(input.faceCount());
  PackedInput::FaceCursor cursor(input);
  uint64_t face = 0;
  for (PackedInput::FaceBlock block; cursor.next(block);)
    forEachFace(block, [&](size_t first, size_t corners) {
      const auto of_face = std::span<const uint32_t>(block.corners).subspan(first, corners);
      for (const uint32_t corner : of_face) result.used.add(corner);
      if (face++ % stride == 0) result.faces.push_back(sampledFace(of_face));
    });
  return result;
}

/// Returns the largest valid lattice step (see isLatticeStep()) that is at most `value`.
double stepAtMost(double value) {
  int exponent = 0;
  const double eighths = std::floor(8 * std::frexp(value, &exponent));
  return std::ldexp(eighths, exponent - 3);
}
double powerOfTwoAtLeast(double value) { return std::exp2(std::ceil(std::log2(value))); }

/// Returns the smallest power of two that is usable as a step: the box fits the lattice, and double
/// represents all coordinates exactly. The factor 4 leaves room for steps of 5, 6 or 7 times a power of two,
/// because their multiples have more bits.
double finestStep(glm::dvec3 box_min, glm::dvec3 box_max) {
  const glm::dvec3 size = box_max - box_min;
  const glm::dvec3 farthest = glm::max(glm::abs(box_min), glm::abs(box_max));
  return std::max(powerOfTwoAtLeast(std::max({size.x, size.y, size.z}) / kMostStepsInBox),
                  powerOfTwoAtLeast(std::max({farthest.x, farthest.y, farthest.z}) * 4 *
                                    std::numeric_limits<double>::epsilon()));
}

Lattice latticeOf(double step, glm::dvec3 box_min) { return {glm::floor(box_min / step) * step, step}; }

std::vector<double> edgesOf(std::span<const SampledFace> faces, const PositionOf& position_of) {
  std::vector<double> edges;
  edges.reserve(faces.size() * 4);
  for (const SampledFace& face : faces) {
    for (size_t c = 0; c < 4; ++c) {
      const uint32_t from = face[c], to = face[(c + 1) % 4];
      if (from != to) edges.push_back(glm::distance(position_of(from), position_of(to)));
    }
  }
  return edges;
}

}  // namespace

double chooseStep(std::vector<double>& edges, glm::dvec3 box_min, glm::dvec3 box_max) {
  const double finest = finestStep(box_min, box_max);
  std::erase(edges, 0.0);
  if (edges.empty()) return finest;
  const auto at = edges.begin() + static_cast<ptrdiff_t>(edges.size() / 20);
  std::nth_element(edges.begin(), at, edges.end());
  const glm::dvec3 size = box_max - box_min;
  const double side = std::max({size.x, size.y, size.z});
  return std::max(finest, stepAtMost(std::min(*at / kStepsInShortEdge, side / kLeastStepsInBox)));
}

SampledFace sampledFace(std::span<const uint32_t> corners) {
  return {corners[0], corners[1], corners[2], corners[corners.size() > 3 ? 3 : 0]};
}

uint64_t faceStride(uint64_t faces) noexcept { return std::max<uint64_t>(1, faces / kSampledFaces); }

bool isLost(std::span<const uint32_t> corners, const PositionOf& position_of, const Lattice& lattice) {
  bool meets = false;
  size_t sides = 0;
  glm::dvec3 from = position_of(corners.back());
  uint32_t from_vertex = corners.back();
  for (const uint32_t to_vertex : corners) {
    if (to_vertex == from_vertex) continue;
    const glm::dvec3 to = position_of(to_vertex);
    sides += from != to;
    meets |= from != to && lattice.snap(from) == lattice.snap(to);
    from = to;
    from_vertex = to_vertex;
  }
  return meets && sides > 2;
}

Lattice chooseLattice(std::span<const SampledFace> faces, const PositionOf& position_of, glm::dvec3 box_min,
                      glm::dvec3 box_max) {
  std::vector<double> edges = edgesOf(faces, position_of);
  const double coarsest = chooseStep(edges, box_min, box_max), finest = finestStep(box_min, box_max);
  releaseStorage(edges);
  std::vector<SampledFace> at_risk;  // only these faces can be lost with step `coarsest` or a smaller step
  const auto reaches = [&](const SampledFace& face) {
    for (size_t c = 0; c < 4; ++c) {
      if (face[c] == face[(c + 1) % 4]) continue;
      const glm::dvec3 along = glm::abs(position_of(face[c]) - position_of(face[(c + 1) % 4]));
      if (std::max({along.x, along.y, along.z}) <= coarsest) return true;
    }
    return false;
  };
  std::ranges::copy_if(faces, std::back_inserter(at_risk), reaches);
  const auto lostAt = [&](double step) {
    const Lattice lattice = latticeOf(step, box_min);
    return static_cast<uint64_t>(std::ranges::count_if(
        at_risk, [&](const SampledFace& face) { return isLost(face, position_of, lattice); }));
  };
  const uint64_t bound = std::max(lostAt(finest), faces.size() / kFacesForEachLost);
  double step = coarsest;
  while (step > finest && lostAt(step) > bound) step = std::max(finest, step / 2);
  return latticeOf(step, box_min);
}

UsedVertices findUsedVertices(const PackedInput& input) {
  UsedAndSampled looked = sampleFaces(input);
  std::vector<uint32_t> corners;
  corners.reserve(looked.faces.size() * 4);
  for (const SampledFace& face : looked.faces) corners.insert(corners.end(), face.begin(), face.end());
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  UsedVertices found;
  found.positions.resize(corners.size());
  size_t next = 0;
  input.readVertices(0, input.vertexCount(),
                     [&](uint64_t number, glm::dvec3 position, const VertexAttributes&) {
                       if (!looked.used.contains(number)) return;
                       ++found.count;
                       found.min = glm::min(found.min, position);
                       found.max = glm::max(found.max, position);
                       if (next < corners.size() && corners[next] == number)
                         found.positions[next++] = position;
                     });
  for (SampledFace& face : looked.faces)
    for (uint32_t& corner : face)
      corner =
          static_cast<uint32_t>(std::lower_bound(corners.begin(), corners.end(), corner) - corners.begin());
  found.faces = std::move(looked.faces);
  return found;
}

LatticeOrProblem chooseLattice(const UsedVertices& used) {
  if (used.coincide()) return {{}, "all vertices that faces use coincide; check the file"};
  const Lattice lattice = chooseLattice(
      used.faces, [&](uint32_t corner) { return used.positions[corner]; }, used.min, used.max);
  if (isLatticeStep(lattice.step)) return {lattice, {}};
  return {{}, "the coordinates are too small or too large to store; scale the model to another unit"};
}

LatticeChoice chooseLattice(const PackedInput& input, const std::filesystem::path& name,
                            double most_step_model) {
  const UsedVertices used = findUsedVertices(input);
  const LatticeOrProblem chosen = chooseLattice(used);
  if (!chosen.lattice) throw Error(ErrorCode::kInput, name.string() + ": " + std::string(chosen.problem));
  Lattice lattice = *chosen.lattice;
  if (most_step_model > 0) {
    lattice = latticeOf(stepAtMost(most_step_model), used.min);
    const double least = finestStep(used.min, used.max);
    if (lattice.step < least) {
      char number[32];
      std::snprintf(number, sizeof number, "%.9g", least);
      throw Error(ErrorCode::kInput,
                  name.string() + ": the model is too large for this --step; use " + number + " or more");
    }
  }
  return {lattice, lattice.snap(used.max), used.min, used.max, 0};
}

}  // namespace lode::ingest
