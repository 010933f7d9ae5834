#pragma once

#include <optional>

#include "server/ingest/measure/farthest_in_triangle.h"
#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/measure/triangle_tree.h"

namespace lode::ingest {

/// Measures distances from points to an LOD's surface. Walks from a nearby triangle if one is known.
/// Otherwise, or if the walk ends too far away, searches all triangles: the first searches test each
/// triangle, later searches use a tree. Building a tree costs about as much as fifty searches. Not thread
/// safe.
class LodSurface {
 public:
  /// @param lod  a mesh with triangles; must outlive this object.
  explicit LodSurface(const NodeMesh& lod) : lod_(lod), walk_(lod) {}

  const SurfaceWalk& walk() const noexcept { return walk_; }
  /// Returns the nearest triangle; see TriangleTree::nearest().
  TriangleTree::Nearest nearest(glm::vec3 point, float tolerance = 0,
                                TriangleTree::Nearest bound = TriangleTree::kNothing) const;

  float squaredDistance(glm::vec3 at, uint32_t triangle) const noexcept {
    return walk_.squaredDistance(at, triangle);
  }

  /// This function and the next two are the interface that FarthestInTriangle needs.
  const PackedTriangle& triangle(uint32_t number) const noexcept { return walk_.triangle(number); }
  bool chainAlong(const Segment& segment, uint32_t first, uint32_t last, float near_squared,
                  TriangleChain& chain) const noexcept {
    return walk_.chainAlong(segment, first, last, near_squared, chain);
  }
  MeasuredPoint measure(glm::vec3 at, uint32_t hint, float tolerance) const;
  /// Walks from triangle `hint` without an exact search, so the returned distance may be larger than the true
  /// one.
  MeasuredPoint walkFrom(glm::vec3 at, uint32_t hint, float tolerance) const noexcept;

 private:
  const NodeMesh& lod_;
  const SurfaceWalk walk_;
  mutable int searches_ = 0;
  mutable std::optional<TriangleTree> tree_;
  mutable SearchEffort effort_;
};

}  // namespace lode::ingest
