#include "client/app/window/panel/panel_content.h"

#include <algorithm>
#include <cmath>

#include "client/app/window/panel/panel_figures.h"

namespace lode::app {
namespace {

constexpr double kAlmost = 0.99;  ///< largest progress while the picture has not converged

OnGpu onGpu(const ViewedScene& scene) {
  if (scene.overBudget()) return OnGpu::kFull;
  return scene.uploaded() ? OnGpu::kAll : OnGpu::kNotYetAll;
}

/// Makes the two contents equal in what shows only progress. @return true if the panel shows a difference.
bool alignProgress(PanelContent& now, const PanelContent& drawn) {
  if (now.waiting.empty() || drawn.waiting.empty()) return false;
  const bool shows_time = now.waiting_part < 0;
  const bool is_different = now.waiting != drawn.waiting || now.waiting_part != drawn.waiting_part ||
                            (shows_time && now.waited_s != drawn.waited_s);
  now.waiting = drawn.waiting;
  now.waiting_part = drawn.waiting_part;
  now.waited_s = drawn.waited_s;
  return is_different;
}

}  // namespace

double RefiningProgress::update(float error_px, float threshold_px, bool converged) noexcept {
  if (converged) {
    start_px_ = 0;
    return 1;
  }
  start_px_ = std::max(start_px_, error_px);
  if (start_px_ <= threshold_px) return kAlmost;
  const double done = std::log2(start_px_ / std::max(error_px, threshold_px));
  return std::min(kAlmost, done / std::log2(start_px_ / threshold_px));
}

void describe(const ViewedScene& scene, const ViewState& state, PanelContent& content) {
  const stream::StreamStatus& status = scene.status();
  content.counts = status.counts;
  content.exhausted = status.exhausted;
  const bool is_whole = status.cut && status.cut->converged && status.cut->lost_tiles == 0;
  content.converged = state.is_settled && scene.upToDate() && is_whole;
  content.limited = state.is_settled && (status.limited || scene.overBudget());
  content.incomplete = state.is_settled && scene.upToDate() && !is_whole && !status.failure.empty();
  content.waiting_for_server = !state.is_settled && !status.trouble.empty();
  content.notice = noticeOf(status, state.is_offline, onGpu(scene));
  const ViewedScene::GpuUse gpu = scene.gpuUse();
  content.gpu_bytes = gpu.bytes;
  content.gpu_tiles = gpu.tiles;
  content.textured = gpu.textured;
}

Difference differenceOf(PanelContent now, const PanelContent& drawn) {
  now.frame_ms = drawn.frame_ms;
  now.upload_ms = drawn.upload_ms;
  if (now.converged) {
    now.counts.received_bytes = drawn.counts.received_bytes;
    now.counts.link_bytes_per_s = drawn.counts.link_bytes_per_s;
    now.counts.round_trip_ms = drawn.counts.round_trip_ms;
  }
  const bool has_progress = alignProgress(now, drawn);
  // Compare only the shown counts, because the others change in each step of a stream.
  const bool shows_counts = now.waiting.empty();
  if (shows_counts && (figuresOf(now) != figuresOf(drawn) || now.counts.requests != drawn.counts.requests))
    return Difference::kPicture;
  now.counts = drawn.counts;
  if (now != drawn) return Difference::kPicture;
  return has_progress ? Difference::kProgress : Difference::kNone;
}

}  // namespace lode::app
