// Measures culling on a graphics card: bench_gpu STORE... prints a row for each store, distance, threshold
// and drawing method. Converged cuts are drawn off-screen as the window draws them, from a camera that turns
// a little between frames.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
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

using Clock = std::chrono::steady_clock;
using render::OcclusionCulling;

constexpr uint32_t kWidthPx = 1280, kHeightPx = 720;
constexpr std::array kThresholdsPx{1.0f, 0.0f};  // 0 selects all leaves
constexpr int kFrames = 30;
constexpr double kTurnRad = 2e-3;  // between frames

double msSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double medianOf(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

struct Frames {
  std::vector<double> thread_ms, gpu_ms, ms;
  uint64_t triangles = 0;
  std::vector<render::Image> images;
};

Frames draw(OcclusionCulling way, const core::View& first, render::Renderer& renderer,
            const render::Framebuffer& target, render::AmbientOcclusion* occlusion) {
  Frames frames;
  const render::GlTimeQuery query = render::GlTimeQuery::create();
  for (int frame = 0; frame < kFrames; ++frame) {
    const core::View view = turned(first, frame * kTurnRad);
    const Clock::time_point start = Clock::now();
    glBeginQuery(GL_TIME_ELAPSED, query.get());
    frames.triangles = renderer.draw(view, target, {}, {.occlusion_culling = way}).triangles;
    if (occlusion != nullptr) occlusion->darken(target, view.fov_y_rad, render::ColorMode::kSurface);
    target.resolve();
    glEndQuery(GL_TIME_ELAPSED);
    frames.thread_ms.push_back(msSince(start));
    glFinish();
    frames.ms.push_back(msSince(start));
    GLuint64 gpu_ns = 0;
    glGetQueryObjectui64v(query.get(), GL_QUERY_RESULT, &gpu_ns);
    frames.gpu_ms.push_back(static_cast<double>(gpu_ns) * 1e-6);
    frames.images.push_back(target.readPixels());
  }
  return frames;
}

size_t differingPixels(const std::vector<render::Image>& some, const std::vector<render::Image>& others) {
  size_t differing = 0;
  for (size_t frame = 0; frame < some.size(); ++frame)
    for (size_t i = 0; i < some[frame].rgba.size(); i += 4)
      differing += !std::equal(&some[frame].rgba[i], &some[frame].rgba[i] + 4, &others[frame].rgba[i]);
  return differing;
}

void measure(const std::string& name, const core::Cut& cut, render::Renderer& renderer,
             const render::Framebuffer& target) {
  using enum OcclusionCulling;
  render::AmbientOcclusion occlusion;
  std::vector<render::Image> all;
  const auto tell = [&](const char* way, OcclusionCulling occlusion_culling,
                        render::AmbientOcclusion* darkens) {
    Frames frames = draw(occlusion_culling, cut.view, renderer, target, darkens);
    if (all.empty()) all = frames.images;
    nlohmann::ordered_json row{{"view", name},
                               {"way", way},
                               {"triangles_of_cut", cut.triangles},
                               {"triangles_drawn", frames.triangles},
                               {"thread_ms", medianOf(frames.thread_ms)},
                               {"gpu_ms", medianOf(frames.gpu_ms)},
                               {"ms", medianOf(frames.ms)}};
    if (darkens == nullptr) row["differing_pixels"] = differingPixels(all, frames.images);
    printRow(row);
  };
  tell("all in the picture", kOff, nullptr);
  tell("hidden found by the GPU", kOnGpu, nullptr);
  tell("hidden read back", kReadBack, nullptr);
  tell("found by the GPU, ambient occlusion", kOnGpu, &occlusion);
}

void measure(const std::string& file) {
  const store::Reader store(file);
  Converged client(store);
  SurfaceCameras cameras(store, kWidthPx, kHeightPx);
  render::Renderer renderer(store.summary().lattice.step, {.budget_bytes = uint64_t{4} << 30});
  const render::Framebuffer target(kWidthPx, kHeightPx);
  const core::CameraPath framing =
      core::framingCamera(store.summary(), {.aspect = double{kWidthPx} / kHeightPx});
  const std::vector<std::pair<std::string, core::View>> places{
      {"framed", core::toView(framing.keys.front(), framing.fov_y_deg, kWidthPx, kHeightPx, store.summary())},
      {"near", cameras.next(0.12)}};
  for (const float threshold_px : kThresholdsPx) {
    for (const auto& [from, view] : places) {
      const auto cut = client.cut(view, threshold_px);
      renderer.show(cut);
      renderer.uploadInRenderThread({.wait = true});
      std::string name = std::filesystem::path(file).stem().string();
      name.append(", ").append(from).append(", ").append(std::to_string(static_cast<int>(threshold_px)));
      name.append(" px");
      measure(name, *cut, renderer, target);
    }
  }
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  const lode::render::OffscreenContext context;
  if (!lode::render::GpuCulling::isPossible()) {
    std::fputs("bench_gpu: this driver does not count draws\n", stderr);
    return 1;
  }
  std::fprintf(stderr, "%s\n", reinterpret_cast<const char*>(glGetString(GL_RENDERER)));
  for (int i = 1; i < argc; ++i) lode::bench::measure(argv[i]);
}
