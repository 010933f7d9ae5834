#include "client/app/window/panel_content.h"

namespace lode::app {

void describe(const Exhibit& exhibit, PanelContent& content) {
  const core::EngineCounts& counts = exhibit.status().counts;
  content.received_bytes = counts.received_bytes;
  content.link_bytes_per_s = counts.link_bytes_per_s;
  content.round_trip_ms = counts.round_trip_ms;
  content.open_wishes = counts.open_wishes;
  content.resident_bytes = counts.resident_bytes + counts.texture_bytes;
  content.tiles_left_out = counts.tiles_left_out;
  content.exhausted = exhibit.status().exhausted;
  const Exhibit::GpuUse gpu = exhibit.gpuUse();
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
