#include <utility>

#include "client/app/window/memory_shares.h"
#include "client/app/window/viewer.h"
#include "client/render/residency/staging_ring.h"

/// What the mouse does over the panel and the settings.
namespace lode::app {

/// The wheel is for a panel that is too high for the window.
void Viewer::scroll(Input& input) {
  PanelScroll* const scroll = input.wheel != 0 ? panel_.scrolledAt(input.pointer_px) : nullptr;
  if (scroll == nullptr) return;
  scroll->turn(std::exchange(input.wheel, 0));
  input.over_panel = true;
}

Settings Viewer::settings() const {
  return {.unlit = show_.shown() == render::ColorMode::kUnlit,
          .darkens_hollows = darkens_hollows_,
          .fades = fades_,
          .exposure = style_.exposure,
          .fixes_threshold = pacing_.isFixed(),
          .threshold_px = pacing_.thresholdPx(),
          .fps = static_cast<float>(pacing_.fps()),
          .memory_bytes = memory_bytes_};
}

/// What differs, so that what is beyond the reach of the settings stays.
void Viewer::apply(const Settings& wanted) {
  const Settings now = settings();
  if (wanted.unlit != now.unlit)
    show_.show(wanted.unlit ? render::ColorMode::kUnlit : render::ColorMode::kSurface);
  darkens_hollows_ = wanted.darkens_hollows;
  fades_ = wanted.fades;
  if (wanted.exposure != now.exposure) style_.exposure = wanted.exposure;
  if (wanted.fixes_threshold != now.fixes_threshold) pacing_.fix(wanted.fixes_threshold);
  if (wanted.threshold_px != now.threshold_px) pacing_.setThreshold(wanted.threshold_px);
  if (wanted.fps != now.fps) pacing_.setRate(wanted.fps);
  if (wanted.memory_bytes == now.memory_bytes) return;
  scene_.setMemory(wanted.memory_bytes);
  noteMemory(wanted.memory_bytes);
}

void Viewer::noteMemory(uint64_t budget_bytes) {
  memory_bytes_ = budget_bytes;
  const render::MemoryShares memory = render::shareMemory(budget_bytes);
  content_.resident_budget_bytes = memory.stream_bytes;
  content_.gpu_budget_bytes = memory.gpu.budget_bytes + memory.gpu.texture_budget_bytes +
                              render::StagingRing::kSegments *
                                  (uint64_t{memory.gpu.staging_bytes} + memory.gpu.texture_staging_bytes);
}

}  // namespace lode::app
