#include "client/app/window/panel/panel_content.h"

namespace lode::app {

namespace {

OnGpu onGpu(const ViewedScene& scene) {
  if (scene.overBudget()) return OnGpu::kFull;
  return scene.uploaded() ? OnGpu::kAll : OnGpu::kNotYetAll;
}

}  // namespace

void describe(const ViewedScene& scene, const Looked& looked, PanelContent& content) {
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
  content.converged = looked.is_settled && scene.upToDate() && is_whole;
  content.limited = looked.is_settled && (status.limited || scene.overBudget());
  content.lacking = looked.is_settled && scene.upToDate() && !is_whole && !status.failure.empty();
  content.waiting_for_server = !looked.is_settled && !status.trouble.empty();
  content.notice = noticeOf(status, looked.is_offline, onGpu(scene));
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
