#include "server/ingest/soup/lattice_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"
#include "server/ingest/mesh/vertex_set.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kSampledFaces = 1 << 16;
// What payloads and stores can hold: docs/store-format.md.
constexpr double kSmallestStep = 0x1p-100;
constexpr double kLargestStep = 0x1p60;
constexpr double kStepsInShortEdge = 32;
constexpr double kStepsInBox = (1 << kLatticeBits) - 2;

struct UsedVertices {
  VertexSet used;
  std::vector<uint32_t> edge_ends;  ///< pairs of vertices of sampled edges
};

UsedVertices findUsedVertices(const PackedInput& input) {
  UsedVertices result{VertexSet(input.vertexCount()), {}};
  const uint64_t stride = std::max<uint64_t>(1, input.faceCount() / kSampledFaces);
  PackedInput::FaceCursor cursor(input);
  PackedInput::FaceBlock block;
  uint64_t face = 0;
  while (cursor.next(block)) {
    size_t first = 0;
    for (size_t f = 0; f < block.faceCount(); ++f, ++face) {
      const size_t corners = block.corner_counts.empty() ? 3 : block.corner_counts[f];
      for (size_t c = 0; c < corners; ++c) result.used.add(block.corners[first + c]);
      if (face % stride == 0) {
        for (size_t c = 0; c < std::min<size_t>(corners, 4); ++c) {
          result.edge_ends.push_back(block.corners[first + c]);
          result.edge_ends.push_back(block.corners[first + (c + 1) % corners]);
        }
      }
      first += corners;
    }
  }
  return result;
}

double powerOfTwoAtMost(double value) { return std::exp2(std::floor(std::log2(value))); }
double powerOfTwoAtLeast(double value) { return std::exp2(std::ceil(std::log2(value))); }

}  // namespace

double chooseStep(std::vector<double>& edges, glm::dvec3 box_min, glm::dvec3 box_max) {
  const glm::dvec3 size = box_max - box_min;
  const double longest = std::max({size.x, size.y, size.z});
  const glm::dvec3 farthest = glm::max(glm::abs(box_min), glm::abs(box_max));
  const double largest = std::max({farthest.x, farthest.y, farthest.z});
  const double finest = std::max(powerOfTwoAtLeast(longest / kStepsInBox),
                                 powerOfTwoAtLeast(largest * std::numeric_limits<double>::epsilon()));
  std::erase(edges, 0.0);
  if (edges.empty()) return finest;
  const auto at = edges.begin() + static_cast<ptrdiff_t>(edges.size() / 20);
  std::nth_element(edges.begin(), at, edges.end());
  return std::max(finest, powerOfTwoAtMost(*at / kStepsInShortEdge));
}

LatticeChoice chooseLattice(const PackedInput& input, const std::filesystem::path& name) {
  UsedVertices found = findUsedVertices(input);
  std::vector<uint32_t> ends = found.edge_ends;
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  std::vector<glm::dvec3> end_positions(ends.size());

  glm::dvec3 box_min(std::numeric_limits<double>::max()), box_max(std::numeric_limits<double>::lowest());
  size_t next_end = 0;
  input.readVertices(0, input.vertexCount(),
                     [&](uint64_t number, glm::dvec3 position, const VertexAttributes&) {
                       if (!found.used.contains(number)) return;
                       box_min = glm::min(box_min, position);
                       box_max = glm::max(box_max, position);
                       if (next_end < ends.size() && ends[next_end] == number)
                         end_positions[next_end++] = position;
                     });
  if (!glm::any(glm::lessThan(box_min, box_max))) {
    throw Error(ErrorCode::kInput,
                name.string() + ": all vertices that faces use coincide; nothing can be built of it");
  }

  const auto positionOf = [&](uint32_t vertex) {
    return end_positions[static_cast<size_t>(std::lower_bound(ends.begin(), ends.end(), vertex) -
                                             ends.begin())];
  };
  std::vector<double> edges;
  edges.reserve(found.edge_ends.size() / 2);
  for (size_t i = 0; i < found.edge_ends.size(); i += 2) {
    edges.push_back(glm::distance(positionOf(found.edge_ends[i]), positionOf(found.edge_ends[i + 1])));
  }

  LatticeChoice choice;
  choice.lattice.step = chooseStep(edges, box_min, box_max);
  if (!(choice.lattice.step >= kSmallestStep && choice.lattice.step <= kLargestStep)) {
    throw Error(ErrorCode::kInput,
                name.string() +
                    ": the coordinates are too small or too large to be stored; give the model "
                    "in another unit");
  }
  choice.lattice.origin = glm::floor(box_min / choice.lattice.step) * choice.lattice.step;
  choice.extent = choice.lattice.snap(box_max);
  return choice;
}

}  // namespace lode::ingest
