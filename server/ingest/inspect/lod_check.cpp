#include "server/ingest/inspect/lod_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "server/ingest/measure/farthest_in_triangle.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/store/segment_tree.h"

namespace lode::ingest {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Distances below this multiple of the stored error are not measured exactly.
constexpr float kTolerance = 0.75f;
constexpr float kReach = 1.25f;  ///< leaves beyond this multiple of the stored error are skipped
/// A point without a leaf nearby counts as this multiple of the stored error away.
constexpr float kBeyond = 1.3f;
/// Largest number of points per LOD, unless the LOD has more triangles.
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

float areaOf(glm::vec3 a, glm::vec3 b, glm::vec3 c) { return glm::length(glm::cross(b - a, c - a)) / 2; }

glm::vec3 pointIn(glm::vec3 a, glm::vec3 b, glm::vec3 c, Dice& dice) {
  float u = dice.roll(), v = dice.roll();
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  return a + u * (b - a) + v * (c - a);
}

/// Surface for FarthestInTriangle. Threads share the referenced data.
struct SharedSurface {
  const TriangleTree& tree;
  const SurfaceWalk& walk;

  const PackedTriangle& triangle(uint32_t number) const { return tree.triangle(number); }
  bool chainAlong(const Segment& segment, uint32_t first, uint32_t last, float near_squared,
                  TriangleChain& chain) const {
    return walk.chainAlong(segment, first, last, near_squared, chain);
  }
  MeasuredPoint measure(glm::vec3 at, uint32_t hint, float tolerance) const {
    const float squared = tree.squaredDistance(at, hint);
    if (squared <= tolerance * tolerance) return {at, std::sqrt(squared), hint};
    const float walked = walk.distanceFrom(at, hint, tolerance);
    if (walked <= tolerance) return {at, walked, hint};
    const TriangleTree::Nearest nearest = tree.nearest(at, tolerance, {walked * walked, walked, hint});
    return {at, nearest.distance, nearest.triangle};
  }
};

constexpr int kPartsOfBoundary = 16;

store::Segment segmentOf(const store::OpenEdge& boundary) {
  return {glm::dvec3(unpackPosition(boundary.a)), glm::dvec3(unpackPosition(boundary.b))};
}

}  // namespace

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

/// Places points at all corners and inside triangles. The number of points in a triangle is proportional to
/// its area, but at least one.
void LodCheck::placePoints(const Mesh& lod, uint64_t count, Dice dice) {
  for (const PositionCode position : lod.positions) points_.emplace_back(unpackPosition(position) - origin_);
  float total = 0;
  for (const glm::u32vec3& t : lod.triangles) total += areaOf(points_[t.x], points_[t.y], points_[t.z]);
  for (const glm::u32vec3& t : lod.triangles) {
    const glm::vec3 a = points_[t.x], b = points_[t.y], c = points_[t.z];
    const float share = total > 0 ? areaOf(a, b, c) / total : 0;
    const auto inside = 1 + static_cast<uint64_t>(share * static_cast<float>(count));
    for (uint64_t i = 0; i < inside; ++i) points_.push_back(pointIn(a, b, c, dice));
  }
}

glm::ivec3 LodCheck::cellOf(glm::vec3 point) const {
  return glm::clamp(glm::ivec3(point / cell_size_), 0, cells_ - 1);
}

void LodCheck::sortPoints() {
  nearest_ = std::vector<std::atomic<float>>(points_.size());
  for (std::atomic<float>& nearest : nearest_) nearest.store(kInfinity, std::memory_order_relaxed);
  const auto count = static_cast<float>(points_.size());
  cells_ = static_cast<int>(std::clamp(std::sqrt(count / kPointsOfCell), 1.f, kMostCells));
  glm::vec3 size(1);
  for (const glm::vec3 point : points_) size = glm::max(size, point);
  cell_size_ = size / static_cast<float>(cells_);
  const auto numberOf = [&](glm::vec3 point) {
    const glm::ivec3 cell = cellOf(point);
    return static_cast<size_t>((cell.z * cells_ + cell.y) * cells_ + cell.x);
  };
  begin_.assign(static_cast<size_t>(cells_ * cells_ * cells_) + 1, 0);
  for (const glm::vec3 point : points_) ++begin_[numberOf(point) + 1];
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
  std::vector<glm::vec3> sorted(points_.size());
  for (const glm::vec3 point : points_) sorted[next[numberOf(point)]++] = point;
  points_ = std::move(sorted);
}

void LodCheck::add(const LeafSurface& leaf) {
  if (leaf.triangles.empty()) return;
  const float farthest = farthestOf(leaf);
  bringNearer(leaf);
  std::lock_guard lock(mutex_);
  forward_ = std::max(forward_, farthest);
}

float LodCheck::backward() const {
  float farthest = kTolerance * stored_;
  for (const std::atomic<float>& nearest : nearest_)
    farthest = std::max(farthest, std::min(nearest.load(std::memory_order_relaxed), kBeyond * stored_));
  return farthest;
}

float LodCheck::farthestOf(const LeafSurface& leaf) const {
  const float tolerance = kTolerance * stored_;
  const SharedSurface surface{tree_, walk_};
  std::vector<MeasuredPoint> corners(leaf.positions.size(), {glm::vec3(0), -1, 0});
  FarthestInTriangle farthest(surface, tolerance, 0);
  uint32_t hint = 0;
  for (const glm::u32vec3& t : leaf.triangles) {
    for (int k = 0; k < 3; ++k) {
      MeasuredPoint& corner = corners[t[k]];
      if (corner.distance < 0)
        corner = surface.measure(glm::vec3(glm::ivec3(leaf.positions[t[k]] - origin_)), hint, tolerance);
      hint = corner.triangle;
    }
    farthest.process({corners[t.x], corners[t.y], corners[t.z]});
  }
  return farthest.largest();
}

/// Updates the distances of the LOD's points near a leaf.
void LodCheck::bringNearer(const LeafSurface& leaf) {
  const glm::vec3 shift(glm::ivec3(leaf.box.min) - glm::ivec3(origin_));
  const glm::vec3 size(leaf.box.max - leaf.box.min);
  const float reach = kReach * stored_;
  // Leaf triangle nearest to the previous point; the search for the next point starts there.
  uint32_t last = 0;
  const glm::ivec3 low = cellOf(shift - reach), high = cellOf(shift + size + reach);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      const auto row = static_cast<size_t>((z * cells_ + y) * cells_);
      const uint32_t end = begin_[row + static_cast<size_t>(high.x) + 1];
      for (uint32_t i = begin_[row + static_cast<size_t>(low.x)]; i < end; ++i) {
        float current = nearest_[i].load(std::memory_order_relaxed);
        const glm::vec3 point = points_[i] - shift;
        const float away = glm::length(glm::max(glm::max(-point, point - size), 0.f));
        if (current <= kTolerance * stored_ || away > reach || away >= current) continue;
        const float bound = std::min(current, kBeyond * stored_);
        const float beside_last = leaf.tree.squaredDistance(point, last);
        const TriangleTree::Nearest start =
            beside_last < bound * bound ? TriangleTree::Nearest{beside_last, std::sqrt(beside_last), last}
                                        : TriangleTree::Nearest{bound * bound, bound, last};
        const TriangleTree::Nearest nearest = leaf.tree.nearest(point, kTolerance * stored_, start);
        last = nearest.triangle;
        const float distance = nearest.distance;
        while (distance < current &&
               !nearest_[i].compare_exchange_weak(current, distance, std::memory_order_relaxed)) {
        }
      }
    }
  }
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
