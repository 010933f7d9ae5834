// Measures refine() with a million known nodes. The camera is above a plain, whose nodes have four children
// each. The thresholds give cuts that visit hundreds and thousands of nodes.

#include <benchmark/benchmark.h>

#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/hierarchy.h"
#include "client/core/lod/refiner.h"
#include "client/core/lod/seen_places.h"

namespace lode::core {
namespace {

constexpr int kDepth = 10;  // 4^10 leaves, 1.4 million nodes
constexpr Lattice kLattice{{0, 0, 0}, 1.0 / 1024};
constexpr AttributeSet kAttributes{AttributeSet::kNormal};

/// A plain of cells. All nodes are known, and every mesh that a view needs is resident.
class Plain {
 public:
  Plain() : hierarchy_(UINT64_MAX), cache_(UINT64_MAX) {
    HierarchyPage page;
    collect(page, kRootKey, {0, 0}, 0, 2);
    hierarchy_.addRootPage(std::move(page));
    addPagesBelow(kRootKey, {0, 0});
    auto mesh = std::make_shared<Mesh>();
    mesh->positions.resize(3);
    mesh->triangles.resize(1);
    mesh_ = mesh;
  }

  /// Returns a view from above the middle towards a corner.
  static View viewFrom(double x) {
    View view;
    view.eye_model = {x, 512, 60};
    view.forward = glm::normalize(glm::dvec3(1, 0.3, -0.35));
    view.up = glm::normalize(glm::cross(glm::cross(view.forward, glm::dvec3(0, 0, 1)), view.forward));
    return view;
  }

  Refinement refineFor(const View& view, const RefineOptions& options) {
    Refinement result = refine({hierarchy_, cache_, kLattice.step, kAttributes}, view, options);
    benchmark::DoNotOptimize(cache_.use(result.in_use, result.ancestors));
    hierarchy_.use(result.pages, UINT64_MAX);
    return result;
  }

  /// @return the number of nodes that the cut visits.
  size_t converge(const View& view, const RefineOptions& options) {
    while (true) {
      const Refinement now = refineFor(view, options);
      if (now.wanted.empty()) return now.cut->parts.size() * 4 / 3;  // each parent has four children
      for (const Request& request : now.wanted)
        for (uint32_t lod = 0; lod < 2; ++lod) cache_.insert({request.use.mesh.node, lod}, mesh_);
    }
  }

  size_t known() const { return hierarchy_.size(); }

 private:
  struct Cell {
    uint32_t x = 0, y = 0;
  };

  Node makeNode(NodeKey key, Cell cell) {
    const int depth = key.depth();
    const uint32_t side = (1u << 20) >> depth;
    Node node;
    node.key = key;
    node.box = {{cell.x * side, cell.y * side, 0}, {(cell.x + 1) * side, (cell.y + 1) * side, side / 4}};
    const float error_model = 64.0f / static_cast<float>(1u << depth);
    for (uint32_t lod = 0; lod < 2; ++lod) {
      const float error = depth == kDepth ? 0 : error_model * static_cast<float>(1 + lod) / 2;
      node.lods.push_back({{next_blob_++, 8000, {}}, 2000u >> lod, 1000u >> lod, 0, error, 0});
    }
    if (depth < kDepth) node.child_mask = 0x0f;
    if (depth >= 2 && depth % 2 == 0 && depth < kDepth) node.child_page = {next_blob_++, 4000, {}};
    return node;
  }

  void collect(HierarchyPage& page, NodeKey key, Cell cell, int from, int to) {
    std::vector<std::pair<NodeKey, Cell>> level{{key, cell}};
    for (int at = 0; at <= to; ++at) {
      std::vector<std::pair<NodeKey, Cell>> below;
      for (const auto& [node, place] : level) {
        if (at >= from) page.nodes.push_back(makeNode(node, place));
        for (unsigned octant = 0; octant < 4; ++octant)
          below.push_back({node.child(octant), {2 * place.x + (octant & 1), 2 * place.y + (octant >> 1)}});
      }
      level = std::move(below);
    }
  }

  void addPagesBelow(NodeKey key, Cell cell) {
    const int depth = key.depth();
    if (depth == kDepth) return;
    if (depth >= 2 && depth % 2 == 0) {
      HierarchyPage page;
      collect(page, key, cell, 1, 2);
      hierarchy_.addPage(key, std::move(page));
    }
    for (unsigned octant = 0; octant < 4; ++octant)
      addPagesBelow(key.child(octant), {2 * cell.x + (octant & 1), 2 * cell.y + (octant >> 1)});
  }

  uint32_t next_blob_ = 1;
  Hierarchy hierarchy_;
  MeshCache cache_;
  std::shared_ptr<const Mesh> mesh_;
};

void refineWhileTheCameraMoves(benchmark::State& state) {
  static Plain plain;
  const RefineOptions options{.threshold_px = static_cast<float>(state.range(0)) / 100};
  size_t visited = 0;
  for (int step = 0; step < 16; ++step) visited = plain.converge(Plain::viewFrom(200 + step), options);
  int step = 0;
  for (auto _ : state) benchmark::DoNotOptimize(plain.refineFor(Plain::viewFrom(200 + step++ % 16), options));
  state.counters["visited"] = static_cast<double>(visited);
  state.counters["known"] = static_cast<double>(plain.known());
}
/// Measures the occlusion estimate for the largest cut that it accepts, seen at an angle.
void lookAtWhatIsSeen(benchmark::State& state) {
  constexpr uint32_t kSide = 181;  // squares; two triangles each
  Mesh mesh;
  for (uint32_t y = 0; y <= kSide; ++y)
    for (uint32_t x = 0; x <= kSide; ++x)
      mesh.positions.push_back(packPosition({x << 12, y << 12, (x * 7 + y * 3) % 5 << 8}));
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) {
      const uint32_t at = y * (kSide + 1) + x, above = at + kSide + 1;
      mesh.triangles.push_back({at, at + 1, above});
      mesh.triangles.push_back({at + 1, above + 1, above});
    }
  state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
  Cut cut;
  cut.parts.push_back({kRootKey, 0, true, 0, std::make_shared<const Mesh>(std::move(mesh))});
  ModelSummary summary;
  summary.lattice = kLattice;
  summary.box.add({0, 0, 0});
  summary.box.add({kSide << 12, kSide << 12, 4 << 8});
  View& view = cut.view;
  view.eye_model = {362, -100, 500};
  view.forward = glm::normalize(glm::dvec3(0, 1, -1));
  view.up = glm::normalize(glm::dvec3(0, 1, 1));
  for (auto _ : state) benchmark::DoNotOptimize(SeenPlaces::of(cut, summary));
}
BENCHMARK(lookAtWhatIsSeen)->Unit(benchmark::kMillisecond);

BENCHMARK(refineWhileTheCameraMoves)->Arg(400)->Arg(200)->Arg(120)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lode::core

BENCHMARK_MAIN();
