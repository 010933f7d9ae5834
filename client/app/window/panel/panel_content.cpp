#include "client/app/window/panel/panel_content.h"

namespace lode::app {

namespace {

OnGpu onGpu(const ViewerContent& viewer_content) {
  if (viewer_content.overBudget()) return OnGpu::kFull;
  return viewer_content.uploaded() ? OnGpu::kAll : OnGpu::kNotYetAll;
}

}  // namespace

void describe(const ViewerContent& viewer_content, const Looked& looked, PanelContent& content) {
  const stream::StreamStatus& status = viewer_content.status();
  const core::EngineCounts& counts = status.counts;
  content.received_bytes = counts.received_bytes;
  content.link_bytes_per_s = counts.link_bytes_per_s;
  content.round_trip_ms = counts.round_trip_ms;
  content.requests = counts.requests;
  content.resident_bytes = counts.resident_bytes + counts.texture_bytes;
  content.tiles_left_out = counts.tiles_left_out;
  content.exhausted = status.exhausted;
  const bool is_whole = status.cut && status.cut->converged && status.cut->lost_tiles == 0;
  content.converged = looked.is_settled && viewer_content.upToDate() && is_whole;
  content.limited = looked.is_settled && (status.limited || viewer_content.overBudget());
  content.lacking = looked.is_settled && viewer_content.upToDate() && !is_whole && !status.failure.empty();
  content.waiting_for_server = !looked.is_settled && !status.trouble.empty();
  content.notice = noticeOf(status, looked.is_offline, onGpu(viewer_content));
  const ViewerContent::GpuUse gpu = viewer_content.gpuUse();
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
