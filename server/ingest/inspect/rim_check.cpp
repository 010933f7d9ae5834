#include "server/ingest/inspect/rim_check.h"

#include <algorithm>
#include <utility>

#include "server/store/segment_tree.h"

namespace lode::ingest {
namespace {

constexpr int kPartsOfRim = 16;

store::Segment segmentOf(const store::OpenEdge& rim) {
  return {glm::dvec3(unpackPosition(rim.a)), glm::dvec3(unpackPosition(rim.b))};
}

}  // namespace

void RimCheck::addLod(const Mesh& lod) {
  store::OpenEdges rims;
  rims.add(lod);
  of_lods_.push_back(rims.edges());
}

void RimCheck::addLeaf(std::span<const store::OpenEdge> rims) {
  std::lock_guard lock(mutex_);
  of_leaves_.add(rims);
}

std::vector<float> RimCheck::found() {
  const std::vector<store::OpenEdge>& original = of_leaves_.edges();
  std::vector<store::Segment> segments;
  segments.reserve(original.size());
  for (const store::OpenEdge& rim : original) segments.push_back(segmentOf(rim));
  const store::SegmentTree tree(std::move(segments));
  std::vector<float> farthest(of_lods_.size());
  for (size_t i = 0; i < of_lods_.size() && !tree.empty(); ++i) {
    for (const store::OpenEdge& rim : of_lods_[i]) {
      if (std::binary_search(original.begin(), original.end(), rim)) continue;
      const store::Segment segment = segmentOf(rim);
      for (int part = 0; part <= kPartsOfRim; ++part) {
        const glm::dvec3 point = glm::mix(segment.from, segment.to, part / static_cast<double>(kPartsOfRim));
        farthest[i] = std::max(farthest[i], static_cast<float>(tree.distance(point)));
      }
    }
  }
  return farthest;
}

}  // namespace lode::ingest
