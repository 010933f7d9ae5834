#include "server/ingest/measure/lod_surface.h"

#include <cmath>

namespace lode::ingest {
namespace {

constexpr int kMostSearchesOfLod = 32;

}  // namespace

TriangleTree::Nearest LodSurface::nearest(glm::vec3 point, float tolerance,
                                          TriangleTree::Nearest bound) const {
  if (searches_ < kMostSearchesOfLod) {
    ++searches_;
    return walk_.nearestOfAll(point, bound);
  }
  if (!tree_) tree_.emplace(lod_);
  return tree_->nearest(point, tolerance, bound, effort_);
}

MeasuredPoint LodSurface::walkFrom(glm::vec3 at, uint32_t hint, float tolerance) const noexcept {
  const float squared = walk_.squaredDistance(at, hint);
  if (squared <= tolerance * tolerance) return {at, std::sqrt(squared), hint};
  const float walked = walk_.distanceFrom(at, hint, tolerance);
  return {at, walked, hint};
}

MeasuredPoint LodSurface::measure(glm::vec3 at, uint32_t hint, float tolerance) const {
  const MeasuredPoint walked = walkFrom(at, hint, tolerance);
  if (walked.distance <= tolerance) return walked;
  const TriangleTree::Nearest found =
      nearest(at, tolerance, {walked.distance * walked.distance, walked.distance, walked.triangle});
  return {at, found.distance, found.triangle};
}

}  // namespace lode::ingest
