#include "client/app/window/panel/panel_content.h"

#include <algorithm>
#include <cmath>

namespace lode::app {
namespace {

constexpr double kAlmost = 0.99;  ///< largest progress while the picture has not converged

OnGpu onGpu(const ViewedScene& scene) {
  if (scene.overBudget()) return OnGpu::kFull;
  return scene.uploaded() ? OnGpu::kAll : OnGpu::kNotYetAll;
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
  const core::EngineCounts& counts = status.counts;
  content.received_bytes = counts.received_bytes;
  content.link_bytes_per_s = counts.link_bytes_per_s;
  content.round_trip_ms = counts.round_trip_ms;
  content.requests = counts.requests;
  content.resident_bytes = counts.resident_bytes + counts.texture_bytes;
  content.tiles_left_out = counts.tiles_left_out;
  content.exhausted = status.exhausted;
  const bool is_whole = status.cut && status.cut->converged && status.cut->lost_tiles == 0;
  content.converged = state.is_settled && scene.upToDate() && is_whole;
  content.limited = state.is_settled && (status.limited || scene.overBudget());
  content.incomplete = state.is_settled && scene.upToDate() && !is_whole && !status.failure.empty();
  content.waiting_for_server = !state.is_settled && !status.trouble.empty();
  content.notice = noticeOf(status, state.is_offline, onGpu(scene));
  const ViewedScene::GpuUse gpu = scene.gpuUse();
  content.gpu_bytes = gpu.bytes;
  content.tiles = gpu.tiles;
  content.textured = gpu.textured;
}

bool differ(PanelContent now, const PanelContent& drawn) {
  now.frame_ms = drawn.frame_ms;
  now.upload_ms = drawn.upload_ms;
  if (now.converged) {
    now.received_bytes = drawn.received_bytes;
    now.link_bytes_per_s = drawn.link_bytes_per_s;
    now.round_trip_ms = drawn.round_trip_ms;
  }
  return now != drawn;
}

}  // namespace lode::app
