// Measures frame times: bench_frames STORE... prints a row for each store and distance. Converged cuts of one
// pixel are drawn off-screen as the window draws them, with and without ambient occlusion, from a camera that
// turns a little between frames.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "client/core/view/camera_path.h"
#include "client/core/view/framing.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/gl/offscreen_context.h"
#include "client/render/passes/ambient_occlusion.h"
#include "client/render/renderer.h"
#include "server/store/reader.h"
#include "tests/bench/converged.h"
#include "tests/bench/print_row.h"
#include "tests/bench/surface_cameras.h"

namespace lode::bench {
namespace {

constexpr uint32_t kWidthPx = 1280, kHeightPx = 720;
constexpr int kFrames = 15;
constexpr double kTurnRad = 2e-3;  // between frames

double cpuMs() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double medianOf(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

/// Times of frames that are drawn with the same settings.
struct Frames {
  std::vector<double> cpu_ms, ms;
  uint64_t triangles = 0;  ///< triangles of the last frame
  render::Image image;
};

/// @param occlusion  null for none.
void draw(Frames& frames, render::OcclusionCulling occlusion_culling, render::AmbientOcclusion* occlusion,
          const core::View& view, render::Renderer& renderer, const render::Framebuffer& target) {
  using Clock = std::chrono::steady_clock;
  const double cpu_start = cpuMs();
  const auto start = Clock::now();
  frames.triangles = renderer.draw(view, target, {}, {.occlusion_culling = occlusion_culling}).triangles;
  if (occlusion != nullptr) occlusion->darken(target, view.fov_y_rad, render::ColorMode::kSurface);
  target.resolve();
  glFinish();
  frames.cpu_ms.push_back(cpuMs() - cpu_start);
  frames.ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  frames.image = target.readPixels();
}

/// Draws in turns: all clusters in the picture; without hidden clusters; without hidden clusters and with
/// ambient occlusion.
void measure(const std::string& name, const core::Cut& cut, render::Renderer& renderer,
             const render::Framebuffer& target) {
  using enum render::OcclusionCulling;
  Frames all, seen, darkened;
  render::AmbientOcclusion occlusion;
  size_t differing = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    const core::View view = turned(cut.view, frame * kTurnRad);
    draw(all, kOff, nullptr, view, renderer, target);
    draw(seen, kReadBack, nullptr, view, renderer, target);
    draw(darkened, kReadBack, &occlusion, view, renderer, target);
    for (size_t i = 0; i < all.image.rgba.size(); i += 4)
      differing += !std::equal(&all.image.rgba[i], &all.image.rgba[i] + 4, &seen.image.rgba[i]);
  }
  printRow({{"view", name},
            {"triangles_of_cut", cut.triangles},
            {"in_picture", all.triangles},
            {"not_hidden", seen.triangles},
            {"all_cpu_ms", medianOf(all.cpu_ms)},
            {"not_hidden_cpu_ms", medianOf(seen.cpu_ms)},
            {"occlusion_cpu_ms", medianOf(darkened.cpu_ms)},
            {"all_ms", medianOf(all.ms)},
            {"not_hidden_ms", medianOf(seen.ms)},
            {"occlusion_ms", medianOf(darkened.ms)},
            {"differing_pixels", differing}});
}

void measure(const std::string& file) {
  const store::Reader store(file);
  Converged client(store);
  SurfaceCameras cameras(store, kWidthPx, kHeightPx);
  render::Renderer renderer(store.summary().lattice.step);
  const render::Framebuffer target(kWidthPx, kHeightPx);
  const core::CameraPath framing =
      core::framingCamera(store.summary(), {.aspect = double{kWidthPx} / kHeightPx});
  const auto show = [&](const std::string& distance, const core::View& view) {
    const auto cut = client.cut(view, 1);
    renderer.show(cut);
    renderer.uploadInRenderThread({.wait = true});
    measure(std::filesystem::path(file).stem().string() + ", " + distance, *cut, renderer, target);
  };
  show("framed", core::toView(framing.keys.front(), framing.fov_y_deg, kWidthPx, kHeightPx, store.summary()));
  show("near", cameras.next(0.12));
  show("close", cameras.next(0.03));
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  const lode::render::OffscreenContext context;
  for (int i = 1; i < argc; ++i) lode::bench::measure(argv[i]);
}
