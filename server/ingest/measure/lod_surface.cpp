#include "server/ingest/measure/lod_surface.h"

#include <cmath>

namespace lode::ingest {
namespace {

constexpr int kMostLooksAtLod = 32;

}  // namespace

TriangleTree::Nearest LodSurface::nearest(glm::vec3 point, float enough, TriangleTree::Nearest known) const {
  if (looks_ < kMostLooksAtLod) {
    ++looks_;
    return walk_.nearestOfAll(point, known);
  }
  if (!tree_) tree_.emplace(lod_);
  return tree_->nearest(point, enough, known);
}

PointBeside LodSurface::walkFrom(glm::vec3 at, uint32_t hint, float enough) const noexcept {
  const float squared = walk_.squaredDistance(at, hint);
  if (squared <= enough * enough) return {at, std::sqrt(squared), hint};
  const float walked = walk_.distanceFrom(at, hint, enough);
  return {at, walked, hint};
}

PointBeside LodSurface::measure(glm::vec3 at, uint32_t hint, float enough) const {
  const PointBeside walked = walkFrom(at, hint, enough);
  if (walked.distance <= enough) return walked;
  const TriangleTree::Nearest found =
      nearest(at, enough, {walked.distance * walked.distance, walked.distance, walked.triangle});
  return {at, found.distance, found.triangle};
}

}  // namespace lode::ingest
