#include "server/ingest/simplify/cluster.h"

#include <algorithm>
#include <array>
#include <bit>
#include <unordered_set>
#include <utility>

#include "server/ingest/mesh/wedge_finder.h"
#include "server/ingest/simplify/cluster_tree.h"
#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/quadric.h"
#include "server/ingest/simplify/wedge_quadrics.h"

namespace lode::ingest {

namespace {

constexpr uint32_t kNone = ClusterTree::kNone;
constexpr double kStay = 1e-4;  // weight of a point at the cell's mean position, relative to the quadric's
                                // trace; makes the optimum unique on flat surfaces

/// State of an octree cell (see ClusterTree). Merging a cell turns its positions into one position.
struct CellState {
  Quadric quadric;    // sum of the positions' quadrics, minus the error that optimal attributes avoid
  glm::dvec3 sum{0};  // sum of the positions
  uint32_t count = 0;
  // Number of triangles that disappear when this cell merges, but not when only its descendants merge.
  uint32_t deaths = 0;
  glm::dvec3 point{0};
  double cost = 0;
  bool merged = false;
};

/// Finds pairs of triangles with the same corners and opposite orientation, in one pass.
class FoldFinder {
 public:
  explicit FoldFinder(size_t triangles) : first_(std::bit_ceil(triangles + 1), kNone), before_(triangles) {
    entries_.reserve(triangles);
  }

  /// Pairs the triangle `t` with an earlier unpaired triangle that has the same corners in opposite
  /// orientation. @param number  index of `t`. @return index of the earlier triangle. If there is no such
  /// triangle, records `t` and returns kNone.
  uint32_t partnerOf(glm::u32vec3 t, uint32_t number) {
    while (t.x > t.y || t.x > t.z) t = {t.y, t.z, t.x};
    const bool turned = t.y > t.z;
    if (turned) std::swap(t.y, t.z);
    const uint32_t hash = t.x * 0x9E3779B1u ^ t.y * 0x85EBCA77u ^ t.z * 0xC2B2AE3Du;
    uint32_t& first = first_[(hash ^ hash >> 15) & (first_.size() - 1)];
    uint32_t i = first;
    while (i != kNone && entries_[i].corners != t) i = entries_[i].next;
    if (i == kNone) {
      i = static_cast<uint32_t>(entries_.size());
      entries_.push_back({t, std::exchange(first, i), kNone, turned});
    }
    Entry& entry = entries_[i];
    if (entry.last != kNone && entry.turned != turned) {
      return std::exchange(entry.last, before_[entry.last]);
    }
    entry.turned = turned;
    before_[number] = std::exchange(entry.last, number);
    return kNone;
  }

 private:
  struct Entry {
    glm::u32vec3 corners;  // in increasing order
    uint32_t next;         // next entry in the bucket
    uint32_t last;         // last unpaired triangle; before_ links it to earlier unpaired triangles
    bool turned;           // orientation of all unpaired triangles
  };
  std::vector<uint32_t> first_;  // first entry of each bucket
  std::vector<Entry> entries_;
  std::vector<uint32_t> before_;  // previous unpaired triangle with the same corners, indexed by triangle
};

class Clusterer {
 public:
  Clusterer(NodeMesh&& mesh, const CollapseOptions& options);
  void run(std::span<const size_t> targets, const SnapshotSink& sink);

 private:
  void countDeaths();
  void addUpCells();
  void place(uint32_t cell);
  SimplifiedMesh snapshot();
  void joinWedges();
  std::vector<uint32_t> destinations() const;
  std::vector<glm::u32vec3> survivors(const std::vector<uint32_t>& destination) const;

  CollapseMesh mesh_;
  WedgeQuadrics attributes_;
  ClusterTree tree_;
  ClusterWedges wedges_;
  glm::dvec3 max_point_;
  std::vector<CellState> states_;       ///< state of each cell
  std::unordered_set<uint64_t> taken_;  ///< lattice points of locked positions
  WedgeTable values_;                   ///< wedge values of the current snapshot
};

Clusterer::Clusterer(NodeMesh&& mesh, const CollapseOptions& options)
    : mesh_(std::move(mesh), options.node_depth),
      attributes_(mesh_, glm::length(glm::dvec3(options.max_position)), options.attribute_weight),
      tree_(mesh_),
      wedges_(mesh_, tree_),
      max_point_(glm::dvec3(options.max_position) - mesh_.origin),
      states_(tree_.cells().size()) {
  addPlanes(mesh_);
  mesh_.forEachEdge([this](const CollapseMesh::Edge& edge) { addFeature(mesh_, edge); });
  for (uint32_t i = 0; i < mesh_.positions.size(); ++i)
    if (mesh_.positions[i].locked)
      taken_.insert(packPosition(glm::uvec3(mesh_.point(i) + mesh_.origin)).value);
  countDeaths();
  addUpCells();
}

// A triangle disappears when the smallest cell that contains two of its corners is merged.
void Clusterer::countDeaths() {
  for (size_t c = 0; c < mesh_.corner_position.size(); c += 4) {
    const uint32_t* const t = &mesh_.corner_position[c];
    const uint32_t smallest = tree_.commonOfTwo(t[0], t[1], t[2]);
    if (smallest != kNone) ++states_[smallest].deaths;
  }
}

void Clusterer::addUpCells() {
  for (uint32_t i = 0; i < mesh_.positions.size(); ++i) {
    const uint32_t cell = tree_.cellOf(i);
    if (cell == kNone || mesh_.positions[i].count == 0) continue;
    Quadric quadric = mesh_.quadrics[i];
    if (!attributes_.empty())
      mesh_.forEachWedge(i, [&](uint32_t wedge) { attributes_.reduce(quadric, wedge); });
    states_[cell].quadric += quadric;
    states_[cell].sum += mesh_.point(i);
    ++states_[cell].count;
  }
  WedgeQuadrics joined = attributes_;
  for (const uint32_t cell : tree_.order()) {
    CellState& state = states_[cell];
    if (!attributes_.empty()) {
      wedges_.joinCell(cell, [&](uint32_t keep, uint32_t gone) {
        Quadric before;
        joined.reduce(before, keep);
        joined.reduce(before, gone);
        state.quadric.subtract(before, 1);
        joined.join(keep, gone);
        joined.reduce(state.quadric, keep);
      });
    }
    place(cell);
    if (tree_.cells()[cell].parent == kNone) continue;
    CellState& parent = states_[tree_.cells()[cell].parent];
    parent.quadric += state.quadric;
    parent.sum += state.sum;
    parent.count += state.count;
    parent.cost = std::max(parent.cost, state.cost);
  }
}

// Places the merged position at the quadric's optimum, clamped to the cell and the model's box and rounded to
// the lattice. If a locked position occupies that point, uses one of the cell's own positions.
void Clusterer::place(uint32_t number) {
  const ClusterTree::Cell& cell = tree_.cells()[number];
  CellState& state = states_[number];
  if (state.count == 0) {  // no position of the cell has triangles
    state.point = mesh_.point(cell.a_position);
    return;
  }
  const glm::dvec3 mean = state.sum / static_cast<double>(state.count);
  Quadric q = state.quadric;
  q.addPoint(mean, kStay * (q.xx + q.yy + q.zz));
  const glm::dvec3 far = glm::dvec3(static_cast<double>(uint64_t{1} << cell.level));
  glm::dvec3 point = bestPlacement(q, mean - far, mean + far).point;
  point = glm::clamp(point, cell.corner, cell.corner + far - 1.0);
  point = glm::clamp(glm::floor(point + 0.5), -mesh_.origin, max_point_);
  if (!taken_.empty() && taken_.contains(packPosition(glm::uvec3(point + mesh_.origin)).value))
    point = mesh_.point(cell.a_position);
  state.point = point;
  state.cost = std::max(state.cost, state.quadric.at(point));
}

/// Returns the destination of each position: its own index, or, if it lies in merged cells, the number of
/// positions plus the index of the largest of these cells.
std::vector<uint32_t> Clusterer::destinations() const {
  const uint32_t count = static_cast<uint32_t>(mesh_.positions.size());
  std::vector<uint32_t> top(states_.size(), kNone);
  for (auto cell = tree_.order().rbegin(); cell != tree_.order().rend(); ++cell) {
    if (!states_[*cell].merged) continue;
    const uint32_t parent = tree_.cells()[*cell].parent;
    top[*cell] = parent != kNone && top[parent] != kNone ? top[parent] : *cell;
  }
  std::vector<uint32_t> destination(count);
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t cell = tree_.cellOf(i);
    destination[i] = cell != kNone && top[cell] != kNone ? count + top[cell] : i;
  }
  return destination;
}

/// Returns the destinations of each triangle's corners; kNone marks removed triangles.
std::vector<glm::u32vec3> Clusterer::survivors(const std::vector<uint32_t>& destination) const {
  std::vector<glm::u32vec3> result(mesh_.corner_position.size() / 4, glm::u32vec3(kNone));
  FoldFinder folds(result.size());
  for (uint32_t i = 0; i < result.size(); ++i) {
    const uint32_t* const corner = &mesh_.corner_position[4 * i];
    const glm::u32vec3 t(destination[corner[0]], destination[corner[1]], destination[corner[2]]);
    if (t.x == t.y || t.y == t.z || t.z == t.x) continue;
    if (const uint32_t partner = folds.partnerOf(t, i); partner != kNone) {
      result[partner] = glm::u32vec3(kNone);
    } else {
      result[i] = t;
    }
  }
  return result;
}

// Computes the attributes of merged wedges and stores them in values_, at the index that
// ClusterWedges::find() returns.
void Clusterer::joinWedges() {
  wedges_.reset();
  values_ = mesh_.wedges;
  WedgeQuadrics joined = attributes_;
  std::vector<WedgeValue> sums(mesh_.wedges.size());
  std::vector<uint32_t> counts(mesh_.wedges.size(), 1);
  for (uint32_t i = 0; i < sums.size(); ++i) sums[i] = mesh_.wedges.value(i);
  for (uint32_t cell = 0; cell < states_.size(); ++cell) {
    if (!states_[cell].merged) continue;
    wedges_.joinCell(cell, [&](uint32_t keep, uint32_t gone) {
      for (size_t k = 0; k < sums[keep].parts.size(); ++k) sums[keep].parts[k] += sums[gone].parts[k];
      counts[keep] += counts[gone];
      if (!attributes_.empty()) joined.join(keep, gone);
    });
  }
  const std::vector<uint32_t> destination = destinations();
  const uint32_t positions = static_cast<uint32_t>(mesh_.positions.size());
  std::vector<uint8_t> done(sums.size());
  for (size_t c = 0; c < mesh_.corner_position.size(); ++c) {
    if ((c & 3) == 3 || destination[mesh_.corner_position[c]] < positions) continue;
    const uint32_t wedge = wedges_.find(mesh_.corner_wedge[c]);
    if (std::exchange(done[wedge], uint8_t{1})) continue;
    for (float& part : sums[wedge].parts) part /= static_cast<float>(counts[wedge]);
    values_.set(wedge, sums[wedge]);
    if (!attributes_.empty())
      joined.setValues(values_, wedge, states_[destination[mesh_.corner_position[c]] - positions].point);
  }
}

SimplifiedMesh Clusterer::snapshot() {
  const std::vector<uint32_t> destination = destinations();
  const std::vector<glm::u32vec3> triangles = survivors(destination);
  if (mesh_.hasWedges()) joinWedges();
  const uint32_t count = static_cast<uint32_t>(mesh_.positions.size());
  NodeMesh result;
  result.attributes = mesh_.attributes;
  std::vector<uint32_t> new_position(count + states_.size(), kNone), new_wedge(mesh_.wedges.size(), kNone);
  WedgeFinder known;
  const auto positionAt = [&](uint32_t place) {
    uint32_t& position = new_position[place];
    if (position != kNone) return position;
    position = static_cast<uint32_t>(result.positions.size());
    const glm::dvec3 point = place < count ? mesh_.point(place) : states_[place - count].point;
    result.positions.push_back(packPosition(glm::uvec3(point + mesh_.origin)));
    result.lca_depth.push_back(place < count ? mesh_.positions[place].lca_depth : kNeverLocked);
    known.addPosition();
    if (!mesh_.hasWedges()) result.wedge_position.push_back(position);
    return position;
  };
  const auto wedgeAt = [&](uint32_t position, uint32_t old) {  // reuses an equal wedge of the position
    uint32_t& wedge = new_wedge[wedges_.find(old)];
    if (wedge != kNone) return wedge;
    const VertexAttributes code = values_.code(wedges_.find(old));
    wedge = known.find(position, code, result.wedge_attributes);
    if (wedge != WedgeFinder::kNone) return wedge;
    wedge = static_cast<uint32_t>(result.wedge_position.size());
    result.wedge_position.push_back(position);
    result.wedge_attributes.push_back(code);
    known.add(position, wedge, result.wedge_attributes);
    return wedge;
  };
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (triangles[i].x == kNone) continue;
    glm::u32vec3 t;
    for (int k = 0; k < 3; ++k) {
      t[k] = positionAt(triangles[i][k]);
      if (mesh_.hasWedges()) t[k] = wedgeAt(t[k], mesh_.corner_wedge[4 * i + static_cast<size_t>(k)]);
    }
    result.triangles.push_back(t);
  }
  std::vector<uint32_t> remap(count);
  for (uint32_t i = 0; i < count; ++i) remap[i] = new_position[destination[i]];
  return {std::move(result), std::move(remap), true};
}

void Clusterer::run(std::span<const size_t> targets, const SnapshotSink& sink) {
  // Cells in order of increasing cost; among equal costs, children before parents.
  std::vector<std::pair<double, uint32_t>> order;
  for (uint32_t i = 0; i < tree_.order().size(); ++i) order.emplace_back(states_[tree_.order()[i]].cost, i);
  std::sort(order.begin(), order.end());
  size_t live = mesh_.live_triangles;
  auto next = order.begin();
  for (size_t target = 0; target < targets.size(); ++target) {
    for (; live > targets[target] && next != order.end(); ++next) {
      CellState& state = states_[tree_.order()[next->second]];
      state.merged = true;
      live -= state.deaths;
    }
    SimplifiedMesh result = snapshot();
    const bool stuck = result.mesh.triangles.size() > targets[target];
    sink(target, std::move(result));
    if (stuck) return;
  }
}

}  // namespace

void cluster(NodeMesh mesh, std::span<const size_t> targets, const CollapseOptions& options,
             const SnapshotSink& sink) {
  Clusterer(std::move(mesh), options).run(targets, sink);
}

}  // namespace lode::ingest
