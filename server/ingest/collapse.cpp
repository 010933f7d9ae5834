#include "server/ingest/collapse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "server/ingest/collapse_check.h"
#include "server/ingest/collapse_mesh.h"
#include "server/ingest/edge_queue.h"
#include "server/ingest/quadric.h"

namespace lode::ingest {

namespace {

// Weights beside a triangle's plane, which has its area.
constexpr double kPointWeight = 1e-6;  // of a triangle's corners: keeps optima on flat ground and orders them
constexpr double kRimWeight = 2;       // of the plane through a rim, by the square of the edge's length
constexpr double kSeamWeight = 1;      // the same at an attribute seam

constexpr int kLevels = 3;
constexpr std::array<CollapseLimits, kLevels> kLimits{{
    {.least_cosine = 0.2, .least_shape = 0.05, .link_condition = true, .most_triangles = 256},
    {.least_cosine = 0.0, .least_shape = 0.0, .link_condition = false, .most_triangles = 4096},
    {.least_cosine = -1.0, .least_shape = 0.0, .link_condition = false},
}};
constexpr float kPostponed = 4;        // key of a collapse that is not possible now, times this
constexpr int kMostPostponements = 6;  // then it waits for the next round
constexpr double kBreaksFeature = 8;   // cost of a collapse that pulls a position off its seam, times this
constexpr size_t kProgress = 32;       // a round that collapses fewer than 1 of so many edges ends its level

/// Whether a collapse may move an end of an edge.
enum class Freedom { kFree, kPenalised, kNone };

/// What meets where two positions have become one, until the next round looks again.
PositionKind joined(PositionKind a, PositionKind b) {
  if (a > b) std::swap(a, b);
  const bool seam_meets_rim = a != PositionKind::kSmooth && a < PositionKind::kRim && b == PositionKind::kRim;
  return seam_meets_rim ? PositionKind::kRimCorner : b;
}

/// Places that are or have been taken, as bits under a hash; a false alarm costs a detour of one step.
class TakenPlaces {
 public:
  explicit TakenPlaces(size_t positions) {
    size_t bits = 1u << 12;
    while (bits < 32 * positions) bits *= 2;
    words_.resize(bits / 64);
  }
  bool contains(glm::dvec3 p) const noexcept {
    const size_t h = hash(p);
    return words_[h / 64] >> h % 64 & 1;
  }
  void add(glm::dvec3 p) noexcept {
    const size_t h = hash(p);
    words_[h / 64] |= uint64_t{1} << h % 64;
  }

 private:
  size_t hash(glm::dvec3 p) const noexcept {
    const glm::i64vec3 q(p);
    uint64_t h = static_cast<uint64_t>(q.x) * 0x9E3779B97F4A7C15u ^
                 static_cast<uint64_t>(q.y) * 0xC2B2AE3D27D4EB4Fu ^
                 static_cast<uint64_t>(q.z) * 0x165667B19E3779F9u;
    h ^= h >> 32;
    h *= 0xD6E8FEB86659FD93u;
    h ^= h >> 32;
    return h & (64 * words_.size() - 1);
  }
  std::vector<uint64_t> words_;
};

class Collapser {
 public:
  Collapser(NodeMesh&& mesh, const CollapseOptions& options);
  void run(std::span<const size_t> targets, const SnapshotSink& sink);

 private:
  struct Record {
    uint32_t u, v;
    float key;
    uint32_t evaluated_at;  ///< clock_ then
    int8_t postponed;
  };
  struct Candidate {
    Placement placement;
    bool possible = false;
  };

  void addQuadrics();
  void startRound();
  bool collapseNext();
  Candidate evaluate(uint32_t u, uint32_t v) const;
  Freedom freedom(uint32_t position, EdgeKind edge) const;
  void put(uint32_t item, double cost);
  glm::dvec3 settle(const Placement& placement, uint32_t u, uint32_t v) const;
  void apply(uint32_t u, uint32_t v, glm::dvec3 to, bool folds);
  uint32_t find(uint32_t position) noexcept;

  CollapseMesh mesh_;
  CollapseCheck check_;
  glm::dvec3 max_point_;
  std::vector<Quadric> quadrics_;
  std::vector<uint32_t> forward_;    // of merged positions; itself while it lives
  std::vector<uint32_t> merged_at_;  // clock_ of a position's last merge
  std::vector<Record> records_;
  EdgeQueue queue_;
  TakenPlaces taken_;
  uint32_t clock_ = 0;
  int level_ = 0;
  size_t collapsed_ = 0;  // in this round
};

Collapser::Collapser(NodeMesh&& mesh, const CollapseOptions& options)
    : mesh_(std::move(mesh), options.node_depth),
      check_(mesh_),
      max_point_(glm::dvec3(options.max_position)),
      quadrics_(mesh_.points.size()),
      forward_(mesh_.points.size()),
      merged_at_(mesh_.points.size(), 0),
      taken_(mesh_.points.size()) {
  for (uint32_t i = 0; i < forward_.size(); ++i) forward_[i] = i;
  for (const glm::dvec3 point : mesh_.points) taken_.add(point);
  addQuadrics();
}

void Collapser::addQuadrics() {
  const auto triangle = [this](uint32_t corner) {
    const uint32_t c = corner & ~3u;
    return std::array{mesh_.corner_position[c], mesh_.corner_position[c + 1], mesh_.corner_position[c + 2]};
  };
  const auto normalOf = [this](const std::array<uint32_t, 3>& t) {
    return glm::cross(mesh_.points[t[1]] - mesh_.points[t[0]], mesh_.points[t[2]] - mesh_.points[t[0]]);
  };
  for (uint32_t c = 0; c < mesh_.corner_position.size(); c += 4) {
    const std::array<uint32_t, 3> t = triangle(c);
    const glm::dvec3 normal = normalOf(t);
    const double length = glm::length(normal);
    if (length == 0) continue;
    Quadric q;
    const glm::dvec3 unit = normal / length;
    q.addPlane(unit, -glm::dot(unit, mesh_.points[t[0]]), 0.5 * length);
    for (const uint32_t i : t) {
      quadrics_[i] += q;
      quadrics_[i].addPoint(mesh_.points[i], kPointWeight * 0.5 * length);
    }
  }
  mesh_.forEachEdge([&](const CollapseMesh::Edge& edge) {
    const EdgeKind kind = edge.kind();
    if (kind == EdgeKind::kSmooth || (mesh_.locked[edge.u] && mesh_.locked[edge.v])) return;
    const glm::dvec3 along = mesh_.points[edge.v] - mesh_.points[edge.u];
    const glm::dvec3 across = glm::cross(along, normalOf(triangle(edge.corner)));
    const double length = glm::length(across);
    if (length == 0) return;
    Quadric q;
    const glm::dvec3 unit = across / length;
    q.addPlane(unit, -glm::dot(unit, mesh_.points[edge.u]),
               (kind == EdgeKind::kRim ? kRimWeight : kSeamWeight) * glm::dot(along, along));
    quadrics_[edge.u] += q;
    quadrics_[edge.v] += q;
  });
}

uint32_t Collapser::find(uint32_t position) noexcept {
  while (forward_[position] != position) {
    forward_[position] = forward_[forward_[position]];
    position = forward_[position];
  }
  return position;
}

void Collapser::put(uint32_t item, double cost) {
  Record& record = records_[item];
  double key = std::max(cost, 0.0) + 1e-30;
  for (int i = 0; i < record.postponed; ++i) key *= kPostponed;
  record.key = static_cast<float>(std::min(key, 1e37));
  record.evaluated_at = clock_;
  queue_.push(item, record.key);
}

void Collapser::startRound() {
  mesh_.classifyPositions();
  records_.clear();
  mesh_.forEachEdge([&](const CollapseMesh::Edge& edge) {
    if (mesh_.locked[edge.u] && mesh_.locked[edge.v]) return;
    records_.push_back({edge.u, edge.v, 0, 0, 0});
  });
  queue_.reset(records_.size());
  for (uint32_t i = 0; i < records_.size(); ++i) {
    const Candidate candidate = evaluate(records_[i].u, records_[i].v);
    if (candidate.possible) put(i, candidate.placement.cost);
  }
  collapsed_ = 0;
}

Freedom Collapser::freedom(uint32_t position, EdgeKind edge) const {
  if (mesh_.locked[position]) return Freedom::kNone;
  switch (mesh_.position_kind[position]) {
    case PositionKind::kSmooth:
      return Freedom::kFree;
    case PositionKind::kSeam:
      return edge == EdgeKind::kSeam ? Freedom::kFree : Freedom::kPenalised;
    case PositionKind::kSeamCorner:
      return Freedom::kPenalised;
    case PositionKind::kRim:
      if (edge == EdgeKind::kRim) return Freedom::kFree;
      break;
    case PositionKind::kRimCorner:
      break;
  }
  return level_ == 0 ? Freedom::kNone : Freedom::kPenalised;
}

Collapser::Candidate Collapser::evaluate(uint32_t u, uint32_t v) const {
  const Quadric q = quadrics_[u] + quadrics_[v];
  const glm::dvec3 at_u = mesh_.points[u], at_v = mesh_.points[v];
  const bool smooth_u = mesh_.position_kind[u] == PositionKind::kSmooth && !mesh_.locked[u];
  const bool smooth_v = mesh_.position_kind[v] == PositionKind::kSmooth && !mesh_.locked[v];
  if (smooth_u && smooth_v) return {bestPlacement(q, at_u, at_v), true};
  if (smooth_u) return {{at_v, q.at(at_v)}, true};
  if (smooth_v) return {{at_u, q.at(at_u)}, true};
  const EdgeKind kind = mesh_.edgeKind(u, v);
  const Freedom free_u = freedom(u, kind), free_v = freedom(v, kind);
  const Freedom least = std::min(free_u, free_v);
  if (least == Freedom::kNone) return {};
  Candidate result{free_u == free_v  ? bestPlacement(q, at_u, at_v)
                   : free_u < free_v ? Placement{at_v, q.at(at_v)}
                                     : Placement{at_u, q.at(at_u)},
                   true};
  if (least == Freedom::kPenalised) result.placement.cost *= kBreaksFeature;
  return result;
}

// The best by the quadric of the eight lattice points around a place, of those inside the box that are no
// other position's; the better end where all are taken. (Rounding to the nearest would add the lattice's
// noise to the surface; of eight points one is usually close to it.)
glm::dvec3 Collapser::settle(const Placement& placement, uint32_t u, uint32_t v) const {
  const glm::dvec3 at_u = mesh_.points[u], at_v = mesh_.points[v];
  if (placement.point == at_u || placement.point == at_v) return placement.point;
  const Quadric q = quadrics_[u] + quadrics_[v];
  const glm::dvec3 low = glm::floor(placement.point), gradient = 2.0 * (q.timesA(low) + q.b);
  // Costs of the eight, less that of `low`.
  const double x = q.xx + gradient.x, y = q.yy + gradient.y, z = q.zz + gradient.z;
  const double xy = x + y + 2 * q.xy, xz = x + z + 2 * q.xz, yz = y + z + 2 * q.yz;
  std::array<std::pair<double, uint32_t>, 8> corners{
      {{0, 0}, {x, 1}, {y, 2}, {xy, 3}, {z, 4}, {xz, 5}, {yz, 6}, {xy + z + 2 * (q.xz + q.yz), 7}}};
  const glm::dvec3 highest = max_point_ - mesh_.origin;
  for (size_t next = 0; next < corners.size(); ++next) {
    std::iter_swap(corners.begin() + next, std::min_element(corners.begin() + next, corners.end()));
    const uint32_t bits = corners[next].second;
    const glm::dvec3 place =
        glm::clamp(low + glm::dvec3(bits & 1, bits >> 1 & 1, bits >> 2), -mesh_.origin, highest);
    if (place == at_u || place == at_v || !taken_.contains(place)) return place;
  }
  return q.at(at_u) < q.at(at_v) ? at_u : at_v;
}

void Collapser::apply(uint32_t u, uint32_t v, glm::dvec3 to, bool folds) {
  const glm::dvec3 at_u = mesh_.points[u], along = mesh_.points[v] - at_u;
  const double t =
      std::clamp(glm::dot(to - at_u, along) / std::max(glm::dot(along, along), 1e-300), 0.0, 1.0);
  const bool keep_v =
      mesh_.locked[v] || (!mesh_.locked[u] && mesh_.rings[v].capacity >= mesh_.rings[u].capacity);
  const uint32_t keep = keep_v ? v : u, gone = keep_v ? u : v;
  const uint8_t depth = to == mesh_.points[keep]   ? mesh_.lca_depth[keep]
                        : to == mesh_.points[gone] ? mesh_.lca_depth[gone]
                                                   : kNeverLocked;
  mesh_.position_kind[keep] = joined(mesh_.position_kind[keep], mesh_.position_kind[gone]);
  mesh_.merge(keep, gone, to, keep_v ? 1 - t : t);
  mesh_.lca_depth[keep] = depth;
  quadrics_[keep] += quadrics_[gone];
  forward_[gone] = keep;
  merged_at_[keep] = ++clock_;
  taken_.add(to);
  if (folds) mesh_.removeFolds(keep);
  ++collapsed_;
}

// Takes the next edge from the queue; false when it is empty.
bool Collapser::collapseNext() {
  const uint32_t item = queue_.pop();
  if (item == EdgeQueue::kNone) return false;
  Record& record = records_[item];
  const uint32_t u = find(record.u), v = find(record.v);
  if (u == v) return true;
  const Candidate candidate = evaluate(u, v);
  if (!candidate.possible) return true;
  const bool stale = merged_at_[u] > record.evaluated_at || merged_at_[v] > record.evaluated_at;
  if (stale) {
    record.u = u;
    record.v = v;
    const uint32_t before = queue_.current();
    double key = candidate.placement.cost;
    for (int i = 0; i < record.postponed; ++i) key *= kPostponed;
    if (EdgeQueue::bucketOf(static_cast<float>(std::clamp(key, 0.0, 1e37))) > before) {
      put(item, candidate.placement.cost);
      return true;
    }
  }
  const glm::dvec3 to = settle(candidate.placement, u, v);
  const CollapseFinding finding = check_.look(u, v, to, kLimits[static_cast<size_t>(level_)]);
  if (finding.removed == 0) return true;
  if (!finding.allowed) {
    if (record.postponed < kMostPostponements) {
      ++record.postponed;
      put(item, candidate.placement.cost);
    }
    return true;
  }
  if (finding.folds) {
    const glm::dvec3 along = mesh_.points[u] - mesh_.points[v];
    const double lost = finding.folded_area * glm::dot(along, along);
    if (EdgeQueue::bucketOf(static_cast<float>(std::min(lost, 1e37))) > queue_.current()) {
      put(item, lost);
      return true;
    }
  }
  apply(u, v, to, finding.folds);
  return true;
}

void Collapser::run(std::span<const size_t> targets, const SnapshotSink& sink) {
  size_t reached = 0;
  const auto report = [&] {
    while (reached < targets.size() && mesh_.live_triangles <= targets[reached]) {
      sink(reached, mesh_.compact());
      ++reached;
    }
    return reached == targets.size();
  };
  if (report()) return;
  while (level_ < kLevels) {
    startRound();
    const size_t edges = records_.size();
    while (collapseNext()) {
      if (mesh_.live_triangles <= targets[reached] && report()) return;
    }
    if (collapsed_ * kProgress < edges || collapsed_ == 0) ++level_;
  }
  sink(reached, mesh_.compact());
}

}  // namespace

void collapse(NodeMesh mesh, std::span<const size_t> targets, const CollapseOptions& options,
              const SnapshotSink& sink) {
  Collapser(std::move(mesh), options).run(targets, sink);
}

}  // namespace lode::ingest
