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
#include "server/ingest/simplify/edge_cost.h"
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
    {.least_cosine = 0.3, .least_shape = 0.05, .link_condition = true, .most_triangles = kHubTriangles},
    {.least_cosine = 0.0, .least_shape = 0.0, .link_condition = false, .most_triangles = 4096},
    {.least_cosine = -1.0, .least_shape = 0.0, .link_condition = false},
}};
// Factor by which an edge's cost grows each time its collapse is postponed.
constexpr double kPostponed = 4;
// After this number of postponements, an edge waits for the next round.
constexpr uint32_t kMostPostponements = 6;
// The next level begins after a round that collapses fewer than 1 in 32 of its edges.
constexpr size_t kProgress = 32;
// Around a hub (a vertex with very many triangles), the cost of merging a neighbour into the hub grows by
// this fraction for each trailing zero bit of the neighbour's index; see drop().
constexpr double kSpread = 0.25;
// Factor on the key of a changed edge at a hub when the edge is queued again. The cost of such an edge grows
// with each collapse at the hub, so a key above the present cost saves evaluations.
constexpr double kAhead = 1.5;
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
  /// An edge that was evaluated again after a change; see alreadyQueued().
  struct Seen {
    uint32_t u = 0, v = 0, changed_at = 0;
  };

  size_t startRound(bool is_first);
  bool collapseNext();
  void postpone(Record record, const EdgeCost::Candidate& candidate);
  void collapseEdge(Record record, const EdgeCost::Candidate& candidate);
  bool alreadyQueued(uint32_t u, uint32_t v, uint32_t changed_at);
  /// Returns true if the last level of limits is reached and so many triangles surround the edge that one end
  /// is a hub, a vertex with very many triangles.
  bool isAroundHub(const Record& record) const noexcept {
    return level_ + 1 == kLimits.size() &&
           mesh_.positions[record.u].count + mesh_.positions[record.v].count > kHubTriangles;
  }
  bool canDrop(uint32_t gone, uint32_t keep) const;
  void drop(Record record, uint32_t gone, uint32_t keep, const EdgeCost::Candidate& candidate);
  void put(Record record, double cost);
  void apply(uint32_t u, uint32_t v, glm::dvec3 to, bool folds);
  SimplifiedMesh snapshot();
  uint32_t find(uint32_t position) noexcept;
  void prefetch(Record& record) noexcept;
  Seen& seenPlace(uint32_t u, uint32_t v) noexcept;

  const CollapseOptions options_;
  CollapseMesh mesh_;
  WedgeQuadrics attributes_;
  EdgeCost cost_;
  EdgeSurroundings around_;
  CollapseCheck check_;
  FarPoints far_points_;
  EdgeQueue<Record> queue_;
  LatticePlaces places_;
  std::vector<Seen> seen_;
  /// For each position, the position it was merged into, or itself if it remains.
  std::vector<uint32_t> forward_;
  uint32_t clock_ = 0;  ///< number of collapses so far
  size_t level_ = 0;
};

Collapser::Collapser(NodeMesh&& mesh, const CollapseOptions& options)
    : options_(options),
      mesh_(std::move(mesh), options.node_depth),
      attributes_(mesh_, glm::length(glm::dvec3(options.max_position)), options.attribute_weight),
      cost_(mesh_, attributes_),
      around_(mesh_),
      check_(mesh_),
      far_points_(mesh_),
      places_(mesh_, options.max_position) {
  mesh_.mixes_values = !attributes_.coversAll();
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
    const EdgeCost::Candidate candidate = cost_.evaluate(record.u, record.v);
    if (!candidate.possible) continue;
    put(record, candidate.placement.cost);
    ++possible;
  }
  return possible;
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

// Processes the next edge of the queue; returns false if the queue is empty. Evaluates an edge with changed
// surroundings only when it leaves the queue. Until then, its old key is nearly always a lower bound, because
// adding quadrics rarely lowers a cost.
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
  const EdgeCost::Candidate candidate = cost_.evaluate(record.u, record.v);
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

// Returns true if the position `gone` can merge into the hub `keep` without a check of the hub's many
// triangles. This holds if all triangles at `gone` also have `keep` as a corner: they vanish, and no other
// triangle changes.
bool Collapser::canDrop(uint32_t gone, uint32_t keep) const {
  const CollapsePosition& position = mesh_.positions[gone];
  const bool is_free = position.kind == PositionKind::kSmooth || position.kind == PositionKind::kBoundary;
  if (position.locked || !is_free || position.count > kHubTriangles) return false;
  return std::ranges::all_of(mesh_.around(gone), [&](uint32_t corner) {
    return mesh_.at(CollapseMesh::next(corner)) == keep || mesh_.at(CollapseMesh::previous(corner)) == keep;
  });
}

// Merges the position `gone` into the hub `keep`, or queues the edge again if its cost is too high for now.
// Costs are raised so that every second position around the hub merges first, then every second remaining
// position, and so on. The remaining positions are then evenly spread.
void Collapser::drop(Record record, uint32_t gone, uint32_t keep, const EdgeCost::Candidate& candidate) {
  const double cost = candidate.placement.cost * (1 + kSpread * std::countr_zero(gone | 1u << 31));
  if (EdgeQueue<Record>::bucketOf(keyOf(cost)) <= queue_.current())
    return apply(record.u, record.v, mesh_.point(keep), false);
  record.postponed = 0;
  put(record, cost);
}

// Requeues an edge that cannot collapse now.
void Collapser::postpone(Record record, const EdgeCost::Candidate& candidate) {
  if (record.postponed++ < kMostPostponements) put(record, candidate.placement.cost);
}

void Collapser::collapseEdge(Record record, const EdgeCost::Candidate& candidate) {
  const CollapseLimits& limits = kLimits[level_];
  const uint32_t count_u = mesh_.positions[record.u].count, count_v = mesh_.positions[record.v].count;
  if (count_u + count_v > limits.most_triangles) return postpone(record, candidate);
  if (isAroundHub(record)) {
    const auto [few, many] =
        count_u < count_v ? std::pair(record.u, record.v) : std::pair(record.v, record.u);
    if (canDrop(few, many)) return drop(record, few, many, candidate);
  }
  if (!cost_.mayLookAround(record.u, record.v)) return postpone(record, candidate);
  around_.gather(record.u, record.v);
  if (around_.apexes().empty()) return;
  const glm::dvec3 to = places_.settle(candidate.placement.point, cost_.quadric(),
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
