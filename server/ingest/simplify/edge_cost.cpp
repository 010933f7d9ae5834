#include "server/ingest/simplify/edge_cost.h"

#include <algorithm>
#include <cmath>

namespace lode::ingest {
namespace {

// Cost factor of moving a position off its seam, or off a corner of seams or boundaries.
constexpr double kBreaksFeature = 8;
constexpr double kLeastArea = 1e-6;  // area that replaces zero, in square lattice steps
// Largest number of pairs of wedges for which the cost of an edge includes attributes.
constexpr size_t kMostPairs = 64;
// Limit on the number of triangles that collapses around hubs may check: kLooksOfMesh, plus kLooksPerTriangle
// for each triangle of the mesh.
constexpr uint64_t kLooksOfMesh = 1u << 18, kLooksPerTriangle = 64;

/// Freedom of an edge's end in a collapse: the end may move, may move at a higher cost, or must stay.
enum class Freedom { kFree, kPenalised, kFixed };

Freedom freedomOf(const CollapsePosition& position, EdgeKind edge) {
  if (position.locked) return Freedom::kFixed;
  switch (position.kind) {
    case PositionKind::kSmooth:
    case PositionKind::kBoundary:
      return Freedom::kFree;
    case PositionKind::kSeam:
      return edge == EdgeKind::kSeam ? Freedom::kFree : Freedom::kPenalised;
    case PositionKind::kSeamCorner:
    case PositionKind::kBoundaryCorner:
      break;
  }
  return Freedom::kPenalised;
}

}  // namespace

EdgeCost::EdgeCost(CollapseMesh& mesh, WedgeQuadrics& attributes)
    : mesh_(mesh),
      attributes_(attributes),
      looks_left_(kLooksOfMesh + kLooksPerTriangle * mesh.live_triangles) {}

// The cost of a collapse is the integral of squared distance over the surrounding area, divided by
// breadth(). This cost is a compromise between the integral, which minimises the mean distance per triangle,
// and the integral divided by the area, which minimises the largest distance.
EdgeCost::Candidate EdgeCost::evaluate(uint32_t u, uint32_t v) {
  // Compute the breadth first: square roots are slow, and place() does not need their result.
  const double across = breadth(u, v);
  Candidate candidate = place(u, v);
  candidate.breadth = across;
  candidate.placement.cost /= across;
  return candidate;
}

EdgeCost::Candidate EdgeCost::place(uint32_t u, uint32_t v) {
  const CollapsePosition &end_u = mesh_.positions[u], &end_v = mesh_.positions[v];
  const glm::dvec3 at_u = mesh_.point(u), at_v = mesh_.point(v);
  quadric_ = mesh_.quadrics[u] + mesh_.quadrics[v];
  if (!attributes_.empty()) reduceWedges(quadric_, u, v);
  const Quadric& q = quadric_;
  const bool smooth_u = end_u.kind == PositionKind::kSmooth && !end_u.locked;
  const bool smooth_v = end_v.kind == PositionKind::kSmooth && !end_v.locked;
  const bool boundary_u = end_u.kind == PositionKind::kBoundary && !end_u.locked;
  const bool boundary_v = end_v.kind == PositionKind::kBoundary && !end_v.locked;
  if ((smooth_u || boundary_u) && (smooth_v || boundary_v)) return {bestPlacement(q, at_u, at_v), true};
  if (smooth_u) return {{at_v, q.at(at_v)}, true};
  if (smooth_v) return {{at_u, q.at(at_u)}, true};
  const EdgeKind kind = mesh_.edgeKind(u, v);
  const Freedom free_u = freedomOf(end_u, kind), free_v = freedomOf(end_v, kind);
  const Freedom freer = std::min(free_u, free_v);
  if (freer == Freedom::kFixed) return {};
  Candidate result{free_u == free_v  ? bestPlacement(q, at_u, at_v)
                   : free_u < free_v ? Placement{at_v, q.at(at_v)}
                                     : Placement{at_u, q.at(at_u)},
                   true};
  if (freer == Freedom::kPenalised) result.placement.cost *= kBreaksFeature;
  return result;
}

// Returns the side of a square with about the area of the triangles around both ends; never 0. The area is
// the geometric mean of two values: the true area, and the weight of all planes, which is larger than the
// area if boundary or seam edges end at the two ends. With the weight alone, collapses at boundaries would
// be too cheap. With the area alone, boundaries would keep triangles that the rest of the mesh needs.
double EdgeCost::breadth(uint32_t u, uint32_t v) const noexcept {
  const double area = mesh_.areas[u] + mesh_.areas[v];
  const double weight = mesh_.quadrics[u].weight() + mesh_.quadrics[v].weight();
  return std::sqrt(std::sqrt(std::max(area, kLeastArea) * std::max(weight, kLeastArea)));
}

// Subtracts from `q` the error that vanishes if the merged wedges have optimal attributes.
void EdgeCost::reduceWedges(Quadric& q, uint32_t u, uint32_t v) {
  const uint32_t wedge_u = mesh_.only_wedge[u], wedge_v = mesh_.only_wedge[v];
  if (wedge_u != kManyWedges && wedge_v != kManyWedges) return attributes_.reduce(q, wedge_u, wedge_v);
  if (!mayLookAround(u, v)) return;
  mesh_.findPairs(v, u, pairs_);
  if (pairs_.size() > kMostPairs) return;
  mesh_.forEachWedge(u, [&](uint32_t wedge) {
    if (std::none_of(pairs_.begin(), pairs_.end(), [=](const auto& pair) { return pair.gone == wedge; }))
      attributes_.reduce(q, wedge);
  });
  mesh_.forEachWedge(v, [&](uint32_t wedge) {
    const auto joins = [=](const auto& pair) { return pair.keep == wedge; };
    const auto pair = std::find_if(pairs_.begin(), pairs_.end(), joins);
    if (pair == pairs_.end()) return attributes_.reduce(q, wedge);
    attributes_.reduce(q, wedge, pair->gone);
    for (auto more = std::find_if(pair + 1, pairs_.end(), joins); more != pairs_.end();
         more = std::find_if(more + 1, pairs_.end(), joins))
      attributes_.reduce(q, more->gone);
  });
}

// Without the limit, a vertex with n triangles would take time proportional to n * n: it has about n edges,
// each of which checks n triangles.
bool EdgeCost::mayLookAround(uint32_t u, uint32_t v) {
  const uint32_t triangles = mesh_.positions[u].count + mesh_.positions[v].count;
  if (triangles <= kHubTriangles) return true;
  if (triangles > looks_left_) return false;
  looks_left_ -= triangles;
  return true;
}

}  // namespace lode::ingest
