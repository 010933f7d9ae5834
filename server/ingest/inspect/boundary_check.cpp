#include "server/ingest/inspect/boundary_check.h"

#include <algorithm>
#include <utility>

#include "server/store/segment_tree.h"

namespace lode::ingest {
namespace {

constexpr int kPartsOfBoundary = 16;

store::Segment segmentOf(const store::OpenEdge& boundary) {
  return {glm::dvec3(unpackPosition(boundary.a)), glm::dvec3(unpackPosition(boundary.b))};
}

}  // namespace

void BoundaryCheck::addLod(const Mesh& lod) {
  store::OpenEdges boundaries;
  boundaries.add(lod);
  of_lods_.push_back(boundaries.edges());
}

void BoundaryCheck::addLeaf(std::span<const store::OpenEdge> boundaries) {
  std::lock_guard lock(mutex_);
  of_leaves_.add(boundaries);
}

std::vector<float> BoundaryCheck::found() {
  const std::vector<store::OpenEdge>& original = of_leaves_.edges();
  std::vector<store::Segment> segments;
  segments.reserve(original.size());
  for (const store::OpenEdge& boundary : original) segments.push_back(segmentOf(boundary));
  const store::SegmentTree tree(std::move(segments));
  std::vector<float> farthest(of_lods_.size());
  for (size_t i = 0; i < of_lods_.size() && !tree.empty(); ++i) {
    for (const store::OpenEdge& boundary : of_lods_[i]) {
      if (std::binary_search(original.begin(), original.end(), boundary)) continue;
      const store::Segment segment = segmentOf(boundary);
      for (int part = 0; part <= kPartsOfBoundary; ++part) {
        const glm::dvec3 point =
            glm::mix(segment.from, segment.to, part / static_cast<double>(kPartsOfBoundary));
        farthest[i] = std::max(farthest[i], static_cast<float>(tree.distance(point)));
      }
    }
  }
  return farthest;
}

}  // namespace lode::ingest
