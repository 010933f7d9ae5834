#include "server/ingest/simplify/collapse.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "server/ingest/simplify/cluster.h"
#include "server/ingest/simplify/collapse_check.h"
#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/edge_queue.h"
#include "server/ingest/simplify/edge_surroundings.h"
#include "server/ingest/simplify/far_points.h"
#include "server/ingest/simplify/lattice_places.h"
#include "server/ingest/simplify/quadric.h"
#include "server/ingest/simplify/wedge_quadrics.h"

namespace lode::ingest {

namespace {

// Levels of limits. Each level allows more collapses than the previous level. Most meshes need only the first
// level.
constexpr std::array<CollapseLimits, 3> kLimits{{
    {.least_cosine = 0.3, .least_shape = 0.05, .link_condition = true, .most_triangles = 256},
    {.least_cosine = 0.0, .least_shape = 0.0, .link_condition = false, .most_triangles = 4096},
    {.least_cosine = -1.0, .least_shape = 0.0, .link_condition = false},
}};
// Factor by which an edge's cost grows each time its collapse is postponed.
constexpr double kPostponed = 4;
// After this number of postponements, an edge waits for the next round.
constexpr uint32_t kMostPostponements = 6;
// Cost factor of moving a position off its seam, or off a corner of seams or boundaries.
constexpr double kBreaksFeature = 8;
constexpr double kLeastArea = 1e-6;  // area that replaces zero, in square lattice steps
// The next level begins after a round that collapses fewer than 1 in 32 of its edges.
constexpr size_t kProgress = 32;
// Largest number of pairs of wedges for which the cost of an edge includes attributes.
constexpr size_t kMostPairs = 64;
// Around a hub (a vertex with very many triangles), the cost of merging a neighbour into the hub grows by
// this fraction for each trailing zero bit of the neighbour's index; see drop().
constexpr double kSpread = 0.25;
// Factor on the key of a changed edge at a hub when it is queued again. The cost of such an edge grows with
// each collapse at the hub, and a key above the present cost saves evaluations.
constexpr double kAhead = 1.5;
// Limit on the number of triangles that collapses around hubs may check: kLooksOfMesh, plus kLooksPerTriangle
// for each triangle of the mesh.
constexpr uint64_t kLooksOfMesh = 1u << 18, kLooksPerTriangle = 64;

/// Freedom of an edge's end in a collapse: the end may move, may move at a higher cost, or must stay.
enum class Freedom { kFree, kPenalised, kFixed };

/// Returns the kind that a merged position has until the next round reclassifies all positions.
PositionKind joined(PositionKind a, PositionKind b) {
  if (a > b) std::swap(a, b);
  const bool seam_meets_boundary =
      a != PositionKind::kSmooth && a < PositionKind::kBoundary && b == PositionKind::kBoundary;
  return seam_meets_boundary ? PositionKind::kBoundaryCorner : b;
}

float keyOf(double cost) noexcept { return static_cast<float>(std::clamp(cost, 0.0, 1e37)); }

class Collapser {
 public:
  Collapser(NodeMesh&& mesh, const CollapseOptions& options);
  void run(std::span<const size_t> targets, const SnapshotSink& sink);

 private:
  /// A queued edge. While the edge waits, its ends may merge into other positions.
  struct Record {
    uint32_t u, v;
    uint32_t evaluated_at;  ///< value of clock_ when the edge was evaluated
    uint32_t postponed;     ///< number of times that the edge was postponed
  };
  struct Candidate {
    Placement placement;
    bool possible = false;
    double breadth = 1;  ///< result of breadth()
  };
  /// An edge that was evaluated again after a change; see alreadyQueued().
  struct Seen {
    uint32_t u = 0, v = 0, changed_at = 0;
  };

  size_t startRound(bool is_first);
  bool collapseNext();
  void postpone(Record record, const Candidate& candidate);
  void collapseEdge(Record record, const Candidate& candidate);
  /// Returns the sum of the quadrics at both ends of an edge.
  Quadric quadricOf(uint32_t u, uint32_t v) {
    Quadric q = mesh_.quadrics[u] + mesh_.quadrics[v];
    if (!attributes_.empty()) reduceWedges(q, u, v);
    return q;
  }
  void reduceWedges(Quadric& q, uint32_t u, uint32_t v);
  Candidate evaluate(uint32_t u, uint32_t v);
  Candidate place(uint32_t u, uint32_t v);
  double breadth(uint32_t u, uint32_t v) const noexcept;
  Freedom freedom(const CollapsePosition& position, EdgeKind edge) const;
  bool alreadyQueued(uint32_t u, uint32_t v, uint32_t changed_at);
  /// Returns true if the last level of limits is reached and so many triangles surround the edge that one end
  /// is a hub, a vertex with very many triangles.
  bool isAroundHub(const Record& record) const noexcept {
    return level_ + 1 == kLimits.size() &&
           mesh_.positions[record.u].count + mesh_.positions[record.v].count > kLimits[0].most_triangles;
  }
  bool mayLookAround(uint32_t u, uint32_t v);
  bool canDrop(uint32_t gone, uint32_t keep) const;
  void drop(Record record, uint32_t gone, uint32_t keep, const Candidate& candidate);
  void put(Record record, double cost);
  void apply(uint32_t u, uint32_t v, glm::dvec3 to, bool folds);
  SimplifiedMesh snapshot();
  uint32_t find(uint32_t position) noexcept;
  void prefetch(Record& record) noexcept;
  Seen& seenPlace(uint32_t u, uint32_t v) noexcept;

  const CollapseOptions options_;
  CollapseMesh mesh_;
  WedgeQuadrics attributes_;
  EdgeSurroundings around_;
  CollapseCheck check_;
  FarPoints far_points_;
  EdgeQueue<Record> queue_;
  LatticePlaces places_;
  std::vector<Seen> seen_;
  /// Sum of the quadrics at both ends of the edge that was evaluated last.
  Quadric quadric_;
  std::vector<WedgeTable::Pair> pairs_;  ///< buffer that is reused between calls
  /// For each position, the position it was merged into, or itself if it remains.
  std::vector<uint32_t> forward_;
  uint32_t clock_ = 0;  ///< number of collapses so far
  size_t level_ = 0;
  uint64_t looks_left_ = 0;  ///< number of triangles that further collapses may check; see kLooksPerTriangle
};

Collapser::Collapser(NodeMesh&& mesh, const CollapseOptions& options)
    : options_(options),
      mesh_(std::move(mesh), options.node_depth),
      attributes_(mesh_, glm::length(glm::dvec3(options.max_position)), options.attribute_weight),
      around_(mesh_),
      check_(mesh_),
      far_points_(mesh_),
      places_(mesh_, options.max_position) {
  mesh_.mixes_values = !attributes_.coversAll();
  looks_left_ = kLooksOfMesh + kLooksPerTriangle * mesh_.live_triangles;
  seen_.resize(std::bit_ceil(mesh_.positions.size() / 2 + 1));
  forward_.resize(mesh_.positions.size());
  std::iota(forward_.begin(), forward_.end(), 0u);
}

uint32_t Collapser::find(uint32_t position) noexcept {
  while (forward_[position] != position) {
    forward_[position] = forward_[forward_[position]];
    position = forward_[position];
  }
  return position;
}

Collapser::Seen& Collapser::seenPlace(uint32_t u, uint32_t v) noexcept {
  return seen_[(u * 0x9E3779B1u ^ v * 0x85EBCA77u) >> 7 & (seen_.size() - 1)];
}

// Prefetches the data of a record that will leave the queue soon.
void Collapser::prefetch(Record& record) noexcept {
  record.u = forward_[forward_[record.u]];
  record.v = forward_[forward_[record.v]];
  for (const uint32_t end : {record.u, record.v}) {
    const char* const line = reinterpret_cast<const char*>(&mesh_.quadrics[end]);
    __builtin_prefetch(line);
    __builtin_prefetch(&mesh_.positions[end]);
    __builtin_prefetch(&mesh_.points[end]);
    __builtin_prefetch(line + 64);
    if (!attributes_.empty() && mesh_.only_wedge[end] != kManyWedges)
      attributes_.prefetch(mesh_.only_wedge[end]);
  }
  __builtin_prefetch(&seenPlace(std::min(record.u, record.v), std::max(record.u, record.v)));
}

void Collapser::put(Record record, double cost) {
  for (uint32_t i = 0; i < record.postponed; ++i) cost *= kPostponed;
  record.evaluated_at = clock_;
  queue_.push(record, keyOf(cost));
}

// Fills the queue and returns the number of queued edges. The cost of an edge depends on the kinds of all
// positions, which are known only after a pass over all edges. This pass therefore puts all edges into the
// lowest bucket. The cost of an edge is evaluated when the edge leaves this bucket.
size_t Collapser::startRound(bool is_first) {
  queue_.clear();
  queue_.reserve(mesh_.live_triangles * 3 / 2);
  if (is_first) addPlanes(mesh_);
  size_t edges = 0, possible = 0;
  mesh_.classifyPositions([&](const CollapseMesh::Edge& edge) {
    if (is_first) addFeature(mesh_, edge);
    if (mesh_.positions[edge.u].locked && mesh_.positions[edge.v].locked) return;
    queue_.push({edge.u, edge.v, 0, 0}, 0);
    ++edges;
  });
  for (Record record; edges > 0; --edges) {
    queue_.pop(record, [this](Record& soon) { prefetch(soon); });
    const Candidate candidate = evaluate(record.u, record.v);
    if (!candidate.possible) continue;
    put(record, candidate.placement.cost);
    ++possible;
  }
  return possible;
}

Freedom Collapser::freedom(const CollapsePosition& position, EdgeKind edge) const {
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

// Subtracts from `q` the error that vanishes if the merged wedges have optimal attributes.
void Collapser::reduceWedges(Quadric& q, uint32_t u, uint32_t v) {
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

/// Returns the side of a square with about the area of the triangles around both ends; never 0. The area is
/// the geometric mean of two values: the true area, and the weight of all planes, which is larger than the
/// area if boundary or seam edges end at the two ends. With the weight alone, collapses at boundaries would
/// be too cheap. With the area alone, boundaries would keep triangles that the rest of the mesh needs.
double Collapser::breadth(uint32_t u, uint32_t v) const noexcept {
  const double area = mesh_.areas[u] + mesh_.areas[v];
  const double weight = mesh_.quadrics[u].weight() + mesh_.quadrics[v].weight();
  return std::sqrt(std::sqrt(std::max(area, kLeastArea) * std::max(weight, kLeastArea)));
}

/// Computes the cost of a collapse: the integral of squared distance over the surrounding area, divided by
/// breadth(). This cost is a compromise between the integral, which minimises the mean distance per triangle,
/// and the integral divided by the area, which minimises the largest distance.
Collapser::Candidate Collapser::evaluate(uint32_t u, uint32_t v) {
  // Compute the breadth first: square roots are slow, and place() does not need their result.
  const double across = breadth(u, v);
  Candidate candidate = place(u, v);
  candidate.breadth = across;
  candidate.placement.cost /= across;
  return candidate;
}

Collapser::Candidate Collapser::place(uint32_t u, uint32_t v) {
  const CollapsePosition &end_u = mesh_.positions[u], &end_v = mesh_.positions[v];
  const glm::dvec3 at_u = mesh_.point(u), at_v = mesh_.point(v);
  quadric_ = quadricOf(u, v);
  const Quadric& q = quadric_;
  const bool smooth_u = end_u.kind == PositionKind::kSmooth && !end_u.locked;
  const bool smooth_v = end_v.kind == PositionKind::kSmooth && !end_v.locked;
  const bool boundary_u = end_u.kind == PositionKind::kBoundary && !end_u.locked;
  const bool boundary_v = end_v.kind == PositionKind::kBoundary && !end_v.locked;
  if ((smooth_u || boundary_u) && (smooth_v || boundary_v)) return {bestPlacement(q, at_u, at_v), true};
  if (smooth_u) return {{at_v, q.at(at_v)}, true};
  if (smooth_v) return {{at_u, q.at(at_u)}, true};
  const EdgeKind kind = mesh_.edgeKind(u, v);
  const Freedom free_u = freedom(end_u, kind), free_v = freedom(end_v, kind);
  const Freedom freer = std::min(free_u, free_v);
  if (freer == Freedom::kFixed) return {};
  Candidate result{free_u == free_v  ? bestPlacement(q, at_u, at_v)
                   : free_u < free_v ? Placement{at_v, q.at(at_v)}
                                     : Placement{at_u, q.at(at_u)},
                   true};
  if (freer == Freedom::kPenalised) result.placement.cost *= kBreaksFeature;
  return result;
}

void Collapser::apply(uint32_t u, uint32_t v, glm::dvec3 to, bool folds) {
  const CollapsePosition &end_u = mesh_.positions[u], &end_v = mesh_.positions[v];
  const glm::dvec3 at_u = mesh_.point(u), along = mesh_.point(v) - at_u;
  const double t = std::clamp(glm::dot(to - at_u, along) / glm::dot(along, along), 0.0, 1.0);
  const bool keep_v = end_v.locked || (!end_u.locked && end_v.capacity >= end_u.capacity);
  const uint32_t keep = keep_v ? v : u, gone = keep_v ? u : v;
  CollapsePosition& kept = mesh_.positions[keep];
  if (to != mesh_.point(keep))
    kept.lca_depth = to == mesh_.point(gone) ? mesh_.positions[gone].lca_depth : kNeverLocked;
  kept.kind = joined(kept.kind, mesh_.positions[gone].kind);
  mesh_.merge(keep, gone, to, keep_v ? 1 - t : t);
  if (!attributes_.empty()) {
    for (const WedgeTable::Pair& pair : mesh_.joined()) attributes_.join(pair.keep, pair.gone);
    if (!kept.locked)
      mesh_.forEachWedge(keep, [&](uint32_t wedge) { attributes_.setValues(mesh_.wedges, wedge, to); });
  }
  forward_[gone] = keep;
  kept.merged_at = ++clock_;
  places_.take(to);
  if (folds) mesh_.removeFolds(keep);
}

// Returns true if the edge (u, v) has been queued again since its last change, which happened when clock_ was
// changed_at. A merge turns two edges into one, and the queue still contains both. The function may return
// false for an edge that was queued again; such a mistake only costs time.
bool Collapser::alreadyQueued(uint32_t u, uint32_t v, uint32_t changed_at) {
  Seen& seen = seenPlace(u, v);
  if (seen.u == u && seen.v == v && seen.changed_at == changed_at) return true;
  seen = {u, v, changed_at};
  return false;
}

// Processes the next edge of the queue; returns false if the queue is empty. An edge whose surroundings have
// changed is not evaluated again before it leaves the queue. Until then its old key is nearly always a lower
// bound, because adding quadrics rarely lowers a cost.
bool Collapser::collapseNext() {
  Record record;
  if (!queue_.pop(record, [this](Record& soon) { prefetch(soon); })) return false;
  record.u = find(record.u);
  record.v = find(record.v);
  if (record.u == record.v) return true;
  if (record.u > record.v) std::swap(record.u, record.v);
  const uint32_t changed_at =
      std::max(mesh_.positions[record.u].merged_at, mesh_.positions[record.v].merged_at);
  const bool stale = changed_at > record.evaluated_at;
  if (stale && alreadyQueued(record.u, record.v, changed_at)) return true;
  mesh_.prefetchCorners(record.u);
  mesh_.prefetchCorners(record.v);
  far_points_.prefetch(record.u, record.v);
  const Candidate candidate = evaluate(record.u, record.v);
  if (!candidate.possible) return true;
  if (stale) {
    record.postponed = 0;
    if (EdgeQueue<Record>::bucketOf(keyOf(candidate.placement.cost)) > queue_.current()) {
      put(record, candidate.placement.cost * (isAroundHub(record) ? kAhead : 1));
      return true;
    }
  }
  collapseEdge(record, candidate);
  return true;
}

// Returns true if looks_left_ allows a check of all triangles around both ends of an edge. The limit exists
// because a vertex with n triangles has about n edges, and checking n triangles for each edge takes time
// proportional to n * n.
bool Collapser::mayLookAround(uint32_t u, uint32_t v) {
  const uint32_t triangles = mesh_.positions[u].count + mesh_.positions[v].count;
  if (triangles <= kLimits[0].most_triangles) return true;
  if (triangles > looks_left_) return false;
  looks_left_ -= triangles;
  return true;
}

// Returns true if the position `gone`, which has few triangles, can merge into the hub `keep`, which has very
// many triangles, without a check of the hub's triangles. This is so if all triangles at `gone` also have
// `keep` as a corner, because then they vanish and no other triangle changes.
bool Collapser::canDrop(uint32_t gone, uint32_t keep) const {
  const CollapsePosition& position = mesh_.positions[gone];
  const bool is_free = position.kind == PositionKind::kSmooth || position.kind == PositionKind::kBoundary;
  if (position.locked || !is_free || position.count > kLimits[0].most_triangles) return false;
  return std::ranges::all_of(mesh_.around(gone), [&](uint32_t corner) {
    return mesh_.at(CollapseMesh::next(corner)) == keep || mesh_.at(CollapseMesh::previous(corner)) == keep;
  });
}

// Merges the position `gone` into the hub `keep`, or queues the edge again if its cost is too high for now.
// Costs are raised so that every second position around the hub merges first, then every second remaining
// position, and so on. The remaining positions are then evenly spread.
void Collapser::drop(Record record, uint32_t gone, uint32_t keep, const Candidate& candidate) {
  const double cost = candidate.placement.cost * (1 + kSpread * std::countr_zero(gone | 1u << 31));
  if (EdgeQueue<Record>::bucketOf(keyOf(cost)) <= queue_.current())
    return apply(record.u, record.v, mesh_.point(keep), false);
  record.postponed = 0;
  put(record, cost);
}

// Requeues an edge that cannot collapse now.
void Collapser::postpone(Record record, const Candidate& candidate) {
  if (record.postponed++ < kMostPostponements) put(record, candidate.placement.cost);
}

void Collapser::collapseEdge(Record record, const Candidate& candidate) {
  const CollapseLimits& limits = kLimits[level_];
  const uint32_t count_u = mesh_.positions[record.u].count, count_v = mesh_.positions[record.v].count;
  if (count_u + count_v > limits.most_triangles) return postpone(record, candidate);
  if (isAroundHub(record)) {
    const auto [few, many] =
        count_u < count_v ? std::pair(record.u, record.v) : std::pair(record.v, record.u);
    if (canDrop(few, many)) return drop(record, few, many, candidate);
  }
  if (!mayLookAround(record.u, record.v)) return postpone(record, candidate);
  around_.gather(record.u, record.v);
  if (around_.apexes().empty()) return;
  const glm::dvec3 to = places_.settle(candidate.placement.point, quadric_,
                                       std::sqrt(std::max(candidate.placement.cost, 0.0) / candidate.breadth),
                                       mesh_.point(record.u), mesh_.point(record.v));
  const CollapseFinding finding = check_.check(around_, to, limits);
  if (!finding.allowed) return postpone(record, candidate);
  if (finding.folds) {  // the cost is the area of the coincident, opposite triangles that vanish
    const glm::dvec3 along = mesh_.point(record.u) - mesh_.point(record.v);
    const double lost = finding.folded_area * glm::dot(along, along) / candidate.breadth;
    if (EdgeQueue<Record>::bucketOf(keyOf(lost)) > queue_.current()) {
      record.postponed = 0;
      return put(record, lost);
    }
  }
  const double cost = far_points_.measure(around_, to) * candidate.breadth;
  if (EdgeQueue<Record>::bucketOf(keyOf(cost)) > queue_.current()) {
    record.postponed = 0;
    return put(record, cost);
  }
  apply(record.u, record.v, to, finding.folds);
  far_points_.join(find(record.u));
}

SimplifiedMesh Collapser::snapshot() {
  SimplifiedMesh result;
  std::vector<uint32_t> new_position;
  result.mesh = mesh_.compact(new_position);
  result.remap.resize(forward_.size());
  for (uint32_t i = 0; i < forward_.size(); ++i) result.remap[i] = new_position[find(i)];
  return result;
}

void Collapser::run(std::span<const size_t> targets, const SnapshotSink& sink) {
  size_t reached = 0;
  const auto report = [&] {
    while (reached < targets.size() && mesh_.live_triangles <= targets[reached]) {
      sink(reached, snapshot());
      ++reached;
    }
    if (reached == targets.size()) return true;
    places_.aimFor(targets[reached]);
    return false;
  };
  if (report()) return;
  for (bool first = true; level_ < kLimits.size(); first = false) {
    const size_t queued = startRound(first);
    const uint32_t before = clock_;
    while (collapseNext()) {
      if (mesh_.live_triangles <= targets[reached] && report()) return;
    }
    if ((clock_ - before) * kProgress <= queued) ++level_;
  }
  SimplifiedMesh rest = snapshot();
  cluster(std::move(rest.mesh), targets.subspan(reached), options_,
          [&](size_t target, SimplifiedMesh&& clustered) {
            std::vector<uint32_t> remap = rest.remap;
            for (uint32_t& place : remap)
              if (place != kVanished) place = clustered.remap[place];
            sink(reached + target, {std::move(clustered.mesh), std::move(remap), true});
          });
}

}  // namespace

void collapse(NodeMesh mesh, std::span<const size_t> targets, const CollapseOptions& options,
              const SnapshotSink& sink) {
  Collapser(std::move(mesh), options).run(targets, sink);
}

}  // namespace lode::ingest
