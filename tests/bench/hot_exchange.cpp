// Measures the drawing thread's work for new cuts of a scene with resident meshes: planning the exchange and
// listing the drawn parts in one frame. Needs OpenGL 4.5, but no display.

#include <memory>
#include <optional>
#include <vector>

#include <benchmark/benchmark.h>

#include "client/render/gl/offscreen_context.h"
#include "client/render/residency/cut_exchange.h"
#include "client/render/residency/mesh_residency.h"
#include "common/error.h"
#include "tests/support/test_meshes.h"

namespace lode {
namespace {

constexpr uint32_t kPlaces = 120, kParts = 256;
constexpr uint32_t kLods = 2;

/// Meshes of a model's nodes, and new cuts of all its instances as a refiner publishes them.
class Scene {
 public:
  Scene() {
    for (uint32_t i = 0; i < kParts * kLods; ++i)
      meshes_.push_back(
          std::make_shared<const Mesh>(test::makeGrid(2, 2, {.attributes = {}, .seed = i + 1})));
  }

  /// Returns the cuts of a step. A given number of parts and instances change their LOD in every other step.
  std::shared_ptr<const core::ViewCuts> at(uint64_t step, const benchmark::State& state) const {
    auto placed = std::make_shared<core::ViewCuts>();
    for (uint32_t place = 0; place < kPlaces; ++place)
      placed->cuts.push_back(cutOf(place < state.range(0) && step % kLods != 0 ? state.range(1) : 0));
    placed->all = core::gatherMeshes(placed->cuts);
    return placed;
  }

 private:
  std::shared_ptr<const core::Cut> cutOf(int64_t changed) const {
    auto cut = std::make_shared<core::Cut>();
    for (uint32_t i = 0; i < kParts; ++i) {
      const uint32_t lod = i < changed ? 1 : 0;
      const NodeKey node{8u * 8 * 8 * 8 + i};  // four levels down, depth first
      cut->parts.push_back({node, lod, true, 1, meshes_[i * kLods + lod]});
    }
    return cut;
  }

  std::vector<std::shared_ptr<const Mesh>> meshes_;
};

/// Gives all instances new cuts, as when the camera moves. A given number of instances have other meshes.
void planAnExchange(benchmark::State& state) {
  const Scene scene;
  const auto from = scene.at(0, state), to = scene.at(1, state);
  for (auto _ : state) benchmark::DoNotOptimize(render::CutExchange(from->cuts, to->cuts).steps().size());
}
BENCHMARK(planAnExchange)
    ->Args({1, kParts})
    ->Args({kPlaces, 8})
    ->Args({kPlaces, kParts})
    ->Unit(benchmark::kMicrosecond);

void exchangeCuts(benchmark::State& state) {
  std::optional<render::OffscreenContext> context;
  try {
    context.emplace();
  } catch (const Error& error) {
    return state.SkipWithError(error.what());
  }
  const Scene scene;
  render::MeshResidency residency({});
  uint64_t step = 0;
  for (; step < kLods; ++step) {
    residency.show(scene.at(step, state));
    residency.uploadInRenderThread({.wait = true});
  }
  for (auto _ : state) {
    state.PauseTiming();
    residency.show(scene.at(step++, state));
    state.ResumeTiming();
    residency.uploadInRenderThread({.ms = 1000});
    if (!residency.upToDate()) return state.SkipWithError("not all is exchanged in a frame");
  }
}
BENCHMARK(exchangeCuts)
    ->Args({1, kParts})
    ->Args({kPlaces, 8})
    ->Args({kPlaces, kParts})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace lode
