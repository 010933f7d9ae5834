#include "server/ingest/inspect/lod_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "common/nearest_point.h"
#include "server/ingest/measure/farthest_in_triangle.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/store/segment_tree.h"

namespace lode::ingest {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Distances below this multiple of the stored error are not measured exactly.
constexpr float kTolerance = 0.75f;
/// Leaves farther from a point than this multiple of the stored error are skipped.
constexpr float kReach = 1.25f;
/// Distance assumed for a point without a leaf within kReach, as a multiple of the stored error.
constexpr float kBeyond = 1.3f;
/// Largest number of points per LOD, not counting one point per corner and one per triangle.
constexpr uint64_t kMostPoints = 20000;
constexpr float kPointsOfCell = 8;
constexpr float kMostCells = 32;  ///< largest number of cells along an axis

NodeMesh meshFrom(const Mesh& mesh, glm::uvec3 origin) {
  NodeMesh local;
  local.positions.reserve(mesh.positions.size());
  for (const PositionCode position : mesh.positions) {
    local.wedge_position.push_back(static_cast<uint32_t>(local.positions.size()));
    local.positions.push_back(packPosition(unpackPosition(position) - origin));
  }
  local.triangles = mesh.triangles;
  return local;
}

LatticeBox boxOf(const Mesh& mesh) {
  LatticeBox box;
  for (const PositionCode position : mesh.positions) box.add(unpackPosition(position));
  return box;
}

double areaOf(const TriangleCorners& t) { return glm::length(glm::cross(t[1] - t[0], t[2] - t[0])) / 2; }

glm::dvec3 pointIn(const TriangleCorners& t, Dice& dice) {
  double u = dice.roll(), v = dice.roll();
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  return t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
}

/// The surface that FarthestInTriangle queries: measures how far points of one leaf triangle are from an LOD.
/// Distances above the tolerance are exact. Several threads may share the tree and the walk.
class MeasuredTriangle {
 public:
  MeasuredTriangle(const TriangleTree& tree, const SurfaceWalk& walk) : tree_(tree), walk_(walk) {}

  /// @param corners  corners of the leaf triangle, in lattice steps from the LOD's origin.
  void set(const TriangleCorners& corners) { corners_ = corners; }
  /// Returns the farthest point measured so far on any triangle. Ignores points within the tolerance.
  const FarPoint& farthest() const { return farthest_; }

  const PackedTriangle& triangle(uint32_t number) const { return tree_.triangle(number); }
  bool chainAlong(const Segment& segment, uint32_t first, uint32_t last, float near_squared,
                  TriangleChain& chain) const {
    return walk_.chainAlong(segment, first, last, near_squared, chain);
  }
  MeasuredPoint measure(glm::vec3 at, uint32_t hint, float tolerance) const {
    const float squared = tree_.squaredDistance(at, hint);
    if (squared <= tolerance * tolerance) return {at, std::sqrt(squared), hint};
    const float walked = walk_.distanceFrom(at, hint, tolerance);
    if (walked <= tolerance) return {at, walked, hint};
    const TriangleTree::Nearest nearest = tree_.nearest(at, tolerance, {walked * walked, walked, hint});
    if (nearest.distance <= tolerance) return {at, nearest.distance, nearest.triangle};
    const glm::dvec3 on = nearestPointOfTriangle(glm::dvec3(at), corners_);
    const TriangleTree::ExactNearest exact = tree_.nearestExactly(on, tolerance, {kInfinity, hint});
    farthest_.raiseTo({exact.distance, on});
    return {at, static_cast<float>(exact.distance), exact.triangle};
  }

 private:
  const TriangleTree& tree_;
  const SurfaceWalk& walk_;
  TriangleCorners corners_{};
  mutable FarPoint farthest_;
};

constexpr int kPartsOfBoundary = 16;

store::Segment segmentOf(const store::OpenEdge& boundary) {
  return {glm::dvec3(unpackPosition(boundary.a)), glm::dvec3(unpackPosition(boundary.b))};
}

}  // namespace

void FarPoint::raiseTo(const FarPoint& other) noexcept {
  const auto placeOf = [](const FarPoint& point) { return std::tuple(point.at.x, point.at.y, point.at.z); };
  if (other.steps > steps || (other.steps == steps && placeOf(other) < placeOf(*this))) *this = other;
}

LeafSurface::LeafSurface(const Mesh& leaf)
    : box(boxOf(leaf)), triangles(leaf.triangles), tree(meshFrom(leaf, box.min)) {
  for (const PositionCode position : leaf.positions) positions.push_back(unpackPosition(position));
}

LodCheck::LodCheck(const Mesh& lod, const LatticeBox& box, float stored_steps, uint64_t original,
                   uint64_t seed)
    : LodCheck(meshFrom(lod, box.min), box, stored_steps) {
  placePoints(lod, std::min(original, kMostPoints), Dice(seed));
  sortPoints();
}

LodCheck::LodCheck(const NodeMesh& lod, const LatticeBox& box, float stored_steps)
    : origin_(box.min), stored_(stored_steps), tree_(lod), walk_(lod) {}

/// Places a point at each corner and one inside each triangle, and about `count` more inside triangles, in
/// proportion to their areas.
void LodCheck::placePoints(const Mesh& lod, uint64_t count, Dice dice) {
  for (const PositionCode position : lod.positions) points_.emplace_back(unpackPosition(position) - origin_);
  const auto triangleOf = [&](const glm::u32vec3& t) {
    return TriangleCorners{points_[t.x], points_[t.y], points_[t.z]};
  };
  double total = 0;
  for (const glm::u32vec3& t : lod.triangles) total += areaOf(triangleOf(t));
  for (const glm::u32vec3& t : lod.triangles) {
    const TriangleCorners triangle = triangleOf(t);
    const double share = total > 0 ? areaOf(triangle) / total : 0;
    const auto inside = 1 + static_cast<uint64_t>(share * static_cast<double>(count));
    for (uint64_t i = 0; i < inside; ++i) points_.push_back(pointIn(triangle, dice));
  }
}

glm::ivec3 LodCheck::cellOf(glm::dvec3 point) const {
  return glm::clamp(glm::ivec3(point / cell_size_), 0, cells_ - 1);
}

void LodCheck::sortPoints() {
  nearest_ = std::vector<std::atomic<float>>(points_.size());
  for (std::atomic<float>& nearest : nearest_) nearest.store(kInfinity, std::memory_order_relaxed);
  const auto count = static_cast<float>(points_.size());
  cells_ = static_cast<int>(std::clamp(std::sqrt(count / kPointsOfCell), 1.f, kMostCells));
  glm::dvec3 size(1);
  for (const glm::dvec3 point : points_) size = glm::max(size, point);
  cell_size_ = size / static_cast<double>(cells_);
  const auto numberOf = [&](glm::dvec3 point) {
    const glm::ivec3 cell = cellOf(point);
    return static_cast<size_t>((cell.z * cells_ + cell.y) * cells_ + cell.x);
  };
  begin_.assign(static_cast<size_t>(cells_ * cells_ * cells_) + 1, 0);
  for (const glm::dvec3 point : points_) ++begin_[numberOf(point) + 1];
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
  std::vector<glm::dvec3> sorted(points_.size());
  for (const glm::dvec3 point : points_) sorted[next[numberOf(point)]++] = point;
  points_ = std::move(sorted);
}

void LodCheck::add(const LeafSurface& leaf) {
  if (leaf.triangles.empty()) return;
  const FarPoint farthest = farthestOf(leaf);
  bringNearer(leaf);
  std::lock_guard lock(mutex_);
  forward_.raiseTo(farthest);
}

FarPoint LodCheck::farthest() const {
  FarPoint farthest = forward_;
  if (farthest.steps < kTolerance * stored_) farthest = {kTolerance * stored_};
  for (size_t i = 0; i < points_.size(); ++i) {
    const float nearest = nearest_[i].load(std::memory_order_relaxed);
    const double steps = std::min(nearest, kBeyond * stored_);
    if (steps > farthest.steps) farthest = {steps, points_[i] + glm::dvec3(origin_), true};
  }
  return farthest;
}

/// Returns the point of a leaf that is farthest from the LOD. Ignores points within the tolerance.
FarPoint LodCheck::farthestOf(const LeafSurface& leaf) const {
  const float tolerance = kTolerance * stored_;
  MeasuredTriangle surface(tree_, walk_);
  std::vector<MeasuredPoint> corners(leaf.positions.size(), {glm::vec3(0), -1, 0});
  FarthestInTriangle farthest(surface, tolerance, 0);
  const auto localOf = [&](uint32_t position) { return glm::ivec3(leaf.positions[position] - origin_); };
  uint32_t hint = 0;
  for (const glm::u32vec3& t : leaf.triangles) {
    surface.set({glm::dvec3(localOf(t.x)), glm::dvec3(localOf(t.y)), glm::dvec3(localOf(t.z))});
    for (int k = 0; k < 3; ++k) {
      MeasuredPoint& corner = corners[t[k]];
      if (corner.distance < 0) corner = surface.measure(glm::vec3(localOf(t[k])), hint, tolerance);
      hint = corner.triangle;
    }
    farthest.process({corners[t.x], corners[t.y], corners[t.z]});
  }
  FarPoint found = surface.farthest();
  found.at += glm::dvec3(origin_);
  return found;
}

/// Lowers the distance in nearest_ of each point of the LOD that is nearer to this leaf than to all earlier
/// leaves.
void LodCheck::bringNearer(const LeafSurface& leaf) {
  const glm::dvec3 shift(glm::ivec3(leaf.box.min) - glm::ivec3(origin_));
  const glm::dvec3 size(leaf.box.max - leaf.box.min);
  const double reach = kReach * stored_, enough = kTolerance * stored_;
  // Leaf triangle nearest to the previous point; the search for the next point starts there.
  uint32_t last = 0;
  const glm::ivec3 low = cellOf(shift - reach), high = cellOf(shift + size + reach);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      const auto row = static_cast<size_t>((z * cells_ + y) * cells_);
      const uint32_t end = begin_[row + static_cast<size_t>(high.x) + 1];
      for (uint32_t i = begin_[row + static_cast<size_t>(low.x)]; i < end; ++i) {
        float current = nearest_[i].load(std::memory_order_relaxed);
        const glm::dvec3 point = points_[i] - shift;
        const double away = glm::length(glm::max(glm::max(-point, point - size), 0.0));
        if (current <= enough || away > reach || away >= current) continue;
        const float distance = distanceTo(leaf, point, std::min(current, kBeyond * stored_), last);
        while (distance < current &&
               !nearest_[i].compare_exchange_weak(current, distance, std::memory_order_relaxed)) {
        }
      }
    }
  }
}

/// Returns the distance from a point to a leaf; exact between kTolerance times the stored error and `bound`.
/// @param point  in lattice steps from the minimum of the leaf's box. @param last  the leaf triangle at which
/// the search starts; receives the nearest triangle.
float LodCheck::distanceTo(const LeafSurface& leaf, glm::dvec3 point, float bound, uint32_t& last) const {
  const float enough = kTolerance * stored_;
  const glm::vec3 at(point);
  const float beside_last = std::sqrt(leaf.tree.squaredDistance(at, last));
  if (beside_last <= enough) return beside_last;
  const TriangleTree::Nearest nearest = leaf.tree.nearest(at, enough, {bound * bound, bound, last});
  last = nearest.triangle;
  if (nearest.distance <= enough) return nearest.distance;
  const TriangleTree::ExactNearest exact = leaf.tree.nearestExactly(point, enough, {bound, last});
  last = exact.triangle;
  return static_cast<float>(exact.distance);
}

void BoundaryCheck::addLod(const Mesh& lod) {
  store::OpenEdges boundaries;
  boundaries.add(lod);
  of_lods_.push_back(boundaries.edges());
}

void BoundaryCheck::addLeaf(std::span<const store::OpenEdge> boundaries) {
  std::lock_guard lock(mutex_);
  of_leaves_.add(boundaries);
}

std::vector<FarPoint> BoundaryCheck::farthest() {
  const std::vector<store::OpenEdge>& original = of_leaves_.edges();
  std::vector<store::Segment> segments;
  segments.reserve(original.size());
  for (const store::OpenEdge& boundary : original) segments.push_back(segmentOf(boundary));
  const store::SegmentTree tree(std::move(segments));
  std::vector<FarPoint> farthest(of_lods_.size());
  for (size_t i = 0; i < of_lods_.size() && !tree.empty(); ++i) {
    for (const store::OpenEdge& boundary : of_lods_[i]) {
      if (std::binary_search(original.begin(), original.end(), boundary)) continue;
      const store::Segment segment = segmentOf(boundary);
      for (int part = 0; part <= kPartsOfBoundary; ++part) {
        const glm::dvec3 point =
            glm::mix(segment.from, segment.to, part / static_cast<double>(kPartsOfBoundary));
        farthest[i].raiseTo({tree.distance(point), point, true, true});
      }
    }
  }
  return farthest;
}

}  // namespace lode::ingest
