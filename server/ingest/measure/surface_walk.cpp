#include "server/ingest/measure/surface_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/ingest/mesh/point_triangle.h"

namespace lode::ingest {
namespace {

float squaredLength(glm::vec3 v) noexcept { return glm::dot(v, v); }

}  // namespace

SurfaceWalk::SurfaceWalk(const NodeMesh& mesh) : begin_(mesh.positions.size() + 1) {
  points_.reserve(mesh.positions.size());
  for (const PositionCode code : mesh.positions) points_.emplace_back(unpackPosition(code));
  triangles_.reserve(mesh.triangles.size());
  for (const glm::u32vec3& t : mesh.triangles) {
    triangles_.emplace_back(mesh.wedge_position[t.x], mesh.wedge_position[t.y], mesh.wedge_position[t.z]);
    const glm::u32vec3& corners = triangles_.back();
    for (int k = 0; k < 3; ++k) {
      ++begin_[corners[k]];
      longest_edge_ =
          std::max(longest_edge_, squaredLength(points_[corners[k]] - points_[corners[(k + 1) % 3]]));
    }
  }
  longest_edge_ = std::sqrt(longest_edge_);
  uint32_t end = 0;
  for (uint32_t& begin : begin_) begin = end += begin;
  around_.resize(end);
  for (auto t = static_cast<uint32_t>(triangles_.size()); t-- > 0;) {
    for (int k = 0; k < 3; ++k) around_[--begin_[triangles_[t][k]]] = t;
  }
}

float SurfaceWalk::distance(glm::vec3 point, uint32_t start, float enough) const noexcept {
  return std::sqrt(walk(point, start, enough * enough).squared);
}

float SurfaceWalk::distanceOnwards(glm::vec3 point, uint32_t& start, float enough) const noexcept {
  const Nearest nearest = walk(point, start, enough * enough);
  if (!std::isinf(nearest.squared)) start = triangles_[nearest.triangle].x;
  return std::sqrt(nearest.squared);
}

float SurfaceWalk::squaredDistance(glm::vec3 point, uint32_t triangle) const noexcept {
  const glm::u32vec3& t = triangles_[triangle];
  const glm::vec3 a = points_[t.x];
  return squaredDistanceToTriangle(point - a, {points_[t.y] - a, points_[t.z] - a});
}

PackedTriangle SurfaceWalk::triangle(uint32_t number) const noexcept {
  const glm::u32vec3& t = triangles_[number];
  const glm::vec3 a = points_[t.x];
  return {a, {points_[t.y] - a, points_[t.z] - a}};
}

float SurfaceWalk::distanceFrom(glm::vec3 point, uint32_t& triangle, float enough) const noexcept {
  const glm::u32vec3& t = triangles_[triangle];
  const auto away = [&](uint32_t position) { return squaredLength(points_[position] - point); };
  const float a = away(t.x), b = away(t.y), c = away(t.z);
  const uint32_t start = a <= b && a <= c ? t.x : b <= c ? t.y : t.z;
  const Nearest nearest = walk(point, start, enough * enough);
  triangle = nearest.triangle;
  return std::sqrt(nearest.squared);
}

SurfaceWalk::Place SurfaceWalk::placeOf(glm::vec3 point, uint32_t start) const noexcept {
  if (const std::optional<Place> above = placeAround(point, start)) return *above;
  const Nearest nearest = walk(point, start, 0);
  const glm::u32vec3& t = triangles_[nearest.triangle];
  const glm::vec3 a = points_[t.x];
  const glm::vec2 shares = nearestInTriangle(point - a, {points_[t.y] - a, points_[t.z] - a});
  return {nearest.triangle, {1 - shares.x - shares.y, shares}, std::sqrt(nearest.squared)};
}

/// Most points lie above a triangle around the start; edges and corners then need no look, unless the
/// triangles there look to different sides: across the rim of a plate lies its other side.
std::optional<SurfaceWalk::Place> SurfaceWalk::placeAround(glm::vec3 point,
                                                           uint32_t position) const noexcept {
  float nearest = std::numeric_limits<float>::infinity();
  Place place;
  glm::vec3 first_normal(0);
  for (uint32_t i = begin_[position]; i < begin_[position + 1]; ++i) {
    const glm::u32vec3& t = triangles_[around_[i]];
    const glm::vec3 a = points_[t.x], ap = point - a, ab = points_[t.y] - a, ac = points_[t.z] - a;
    const glm::vec3 normal = glm::cross(ab, ac);
    if (i == begin_[position]) first_normal = normal;
    if (glm::dot(normal, first_normal) < 0) return std::nullopt;
    const float of_b = glm::dot(normal, glm::cross(ap, ac));
    if (!(of_b > 0)) continue;
    const float of_c = glm::dot(normal, glm::cross(ab, ap));
    if (!(of_c > 0)) continue;
    const float all = glm::dot(normal, normal), of_a = all - of_b - of_c;
    if (!(of_a > 0)) continue;
    // From the foot, not along the normal: a sliver's is rounding noise, which may be much too short.
    const float squared = squaredLength(ap - (of_b * ab + of_c * ac) / all);
    if (squared >= nearest) continue;
    nearest = squared;
    place = {around_[i], glm::vec3(of_a, of_b, of_c) / all, std::sqrt(squared)};
  }
  return std::isinf(nearest) ? std::nullopt : std::optional(place);
}

SurfaceWalk::Nearest SurfaceWalk::walk(glm::vec3 point, uint32_t start, float enough_squared) const noexcept {
  Nearest best{std::numeric_limits<float>::infinity(), 0};
  lookAround(point, start, enough_squared, best);
  if (std::isinf(best.squared)) return best;
  glm::u32vec3 done(start);  // corners that have been looked around
  for (float before = std::numeric_limits<float>::infinity(); best.squared < before;) {
    if (best.squared <= enough_squared || isAbove(point, best.triangle)) break;
    before = best.squared;
    const glm::u32vec3 corners = triangles_[best.triangle];
    for (int k = 0; k < 3; ++k) {
      if (corners[k] != done.x && corners[k] != done.y && corners[k] != done.z)
        lookAround(point, corners[k], enough_squared, best);
    }
    done = corners;
  }
  return best;
}

uint32_t SurfaceWalk::beyond(uint32_t triangle, uint32_t from, uint32_t to) const noexcept {
  for (uint32_t i = begin_[from]; i < begin_[from + 1]; ++i) {
    const glm::u32vec3& t = triangles_[around_[i]];
    if (around_[i] != triangle && (t.x == to || t.y == to || t.z == to)) return around_[i];
  }
  return triangle;
}

std::optional<TriangleChain> SurfaceWalk::chainAlong(const Segment& segment, uint32_t first, uint32_t last,
                                                     float near) const noexcept {
  TriangleChain chain;
  chain.triangles[0] = first;
  glm::u32vec2 came_by(~0u);
  while (chain.triangles[chain.edge_count] != last) {
    if (chain.edge_count == TriangleChain::kMostEdges) return std::nullopt;
    const uint32_t here = chain.triangles[chain.edge_count];
    const glm::u32vec3& t = triangles_[here];
    const glm::vec3 normal = glm::cross(points_[t.y] - points_[t.x], points_[t.z] - points_[t.x]);
    float farthest = 0;  // that the segment's end lies beyond an edge
    glm::u32vec2 way(~0u);
    for (int k = 0; k < 3; ++k) {
      const uint32_t from = t[k], to = t[(k + 1) % 3];
      if (from == came_by.y && to == came_by.x) continue;
      const glm::vec3 along = points_[to] - points_[from];
      const float length_squared = glm::dot(along, along);
      const float beyond_edge = glm::dot(glm::cross(along, normal), segment.to - points_[from]);
      if (beyond_edge <= 0 || beyond_edge * beyond_edge <= farthest * farthest * length_squared) continue;
      farthest = beyond_edge / std::sqrt(length_squared);
      way = {from, to};
    }
    if (way.x == ~0u) return std::nullopt;
    const Segment edge{points_[way.x], points_[way.y]};
    if (ingest::squaredDistance(edge, segment) > near * near) return std::nullopt;
    const uint32_t next = beyond(here, way.x, way.y);
    if (next == here) return std::nullopt;
    chain.edges[chain.edge_count++] = edge;
    chain.triangles[chain.edge_count] = next;
    came_by = way;
  }
  return chain;
}

TriangleTree::Nearest SurfaceWalk::nearestOfAll(glm::vec3 point, TriangleTree::Nearest known) const noexcept {
  Nearest best{known.squared, known.triangle};
  float distance = known.distance, reach = distance + longest_edge_;
  for (uint32_t t = 0; t < triangles_.size(); ++t) {
    if (squaredLength(point - points_[triangles_[t].x]) > reach * reach) continue;
    const float before = best.squared;
    lookAt(point, t, best);
    if (best.squared == before) continue;
    distance = std::sqrt(best.squared);
    reach = distance + longest_edge_;
  }
  return {best.squared, distance, best.triangle};
}

/// Whether the triangle's nearest place is inside it, so that its neighbours are farther away.
bool SurfaceWalk::isAbove(glm::vec3 point, uint32_t triangle) const noexcept {
  const glm::u32vec3& t = triangles_[triangle];
  const glm::vec3 a = points_[t.x] - point, b = points_[t.y] - point, c = points_[t.z] - point;
  const glm::vec3 normal = glm::cross(b - a, c - a);
  return glm::dot(normal, glm::cross(a, b)) > 0 && glm::dot(normal, glm::cross(b, c)) > 0 &&
         glm::dot(normal, glm::cross(c, a)) > 0;
}

void SurfaceWalk::lookAround(glm::vec3 point, uint32_t position, float enough_squared,
                             Nearest& best) const noexcept {
  const FourVectors points(point, point, point, point);
  const uint32_t end = begin_[position + 1];
  for (uint32_t i = begin_[position]; i < end && best.squared > enough_squared; i += 4) {
    const auto corner = [&](int k) {
      const auto of = [&](uint32_t at) { return points_[triangles_[around_[std::min(at, end - 1)]][k]]; };
      return FourVectors(of(i), of(i + 1), of(i + 2), of(i + 3));
    };
    const Four found = FourTriangles(corner(0), corner(1), corner(2)).squaredDistances(points);
    for (uint32_t k = 0; k < 4 && best.squared > enough_squared; ++k)
      if (found[k] < best.squared) best = {found[k], around_[i + k]};
  }
}

void SurfaceWalk::lookAt(glm::vec3 point, uint32_t triangle, Nearest& best) const noexcept {
  const float squared = squaredDistance(point, triangle);
  if (squared < best.squared) best = {squared, triangle};
}

}  // namespace lode::ingest
