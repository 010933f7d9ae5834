#include "client/app/window/panel/panel_figures.h"

#include <algorithm>
#include <cstdio>

#include "common/byte_size.h"

namespace lode::app {
namespace {

constexpr const char* kNoBreak = "\u00a0";  ///< no-break space
constexpr double kLeastTripMs = 0.05;       ///< shorter round trips would be shown as 0.0 ms
/// Frames that take up to this multiple of the target time count as on time.
constexpr double kAlmostInTime = 1.1;

std::string countOf(uint64_t value) {
  std::string digits = std::to_string(value);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<size_t>(at), kNoBreak);
  }
  return digits;
}

std::string formatted(const char* format, double a, double b = 0) {
  char text[96];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

std::string nameOf(CameraKind camera) {
  switch (camera) {
    case CameraKind::kFly:
      return "fly: W A S D";
    case CameraKind::kWalk:
      return "walk: W A S D";
    case CameraKind::kOrbit:
      break;
  }
  return "orbit";
}

std::string networkOf(const core::EngineCounts& counts) {
  std::string text = describeBytes(counts.received_bytes);
  if (counts.link_bytes_per_s > 0)
    text += ", " + describeBytes(static_cast<uint64_t>(counts.link_bytes_per_s)) + "/s";
  if (counts.round_trip_ms >= kLeastTripMs) text += formatted(", %.1f ms round trip", counts.round_trip_ms);
  return text;
}

std::string requestsOf(const core::RequestCounts& requests) {
  if (requests.visible + requests.margin + requests.prefetch == 0) return "none";
  return "visible " + countOf(requests.visible) + ", margin " + countOf(requests.margin) + ", prefetch " +
         countOf(requests.prefetch);
}

Figure memoryFigure(const char* name, uint64_t bytes, uint64_t budget_bytes, int rank) {
  const double part = static_cast<double>(bytes) / static_cast<double>(std::max<uint64_t>(1, budget_bytes));
  return {name, describeBytes(bytes) + " of " + describeBytes(budget_bytes), std::min(part, 1.0), rank};
}

std::string tilesOf(const PanelContent& content) {
  const std::string tiles = countOf(content.gpu_tiles) + " tiles";
  const uint64_t left_out = content.counts.tiles_left_out;
  return left_out == 0 ? tiles : tiles + ", no memory for " + countOf(left_out);
}

/// Describes the threshold, and the frame rate that the threshold is raised for. The actual rate can be
/// higher, or lower if FrameRateControl reaches its limits. Before the camera moves, the threshold is raised
/// only for the first pictures.
std::string thresholdOf(const PanelContent& content) {
  std::string text = formatted("%.2f px", content.threshold_px);
  if (content.target_ms <= 0) {
    const bool is_first = content.threshold_px > content.final_threshold_px;
    return is_first ? text + formatted(" at first, then %.2f px", content.final_threshold_px) : text;
  }
  text += formatted(" while moving, for at least %.0f frames per second", 1000 / content.target_ms);
  if (content.frame_ms > kAlmostInTime * content.target_ms) text += ", not reached";
  return text;
}

}  // namespace

std::vector<Figure> figuresOf(const PanelContent& content) {
  std::vector<Figure> figures{
      {"triangles", countOf(content.triangles) + " of " + countOf(content.model_triangles), -1, 1},
      {"nodes", countOf(content.nodes), -1, 8},
      {"network", networkOf(content.counts), -1, 3},
      {"requests", requestsOf(content.counts.requests), -1, 4},
      memoryFigure("memory", content.counts.resident_bytes + content.counts.texture_bytes,
                   content.resident_budget_bytes, 5),
      memoryFigure("on the GPU", content.gpu_bytes, content.gpu_budget_bytes, 6),
  };
  if (content.textured) figures.push_back({"textures", tilesOf(content), -1, 7});
  figures.push_back({"threshold", thresholdOf(content), -1, 0});
  if (content.scale < 1)
    figures.push_back({"pixels",
                       formatted(content.target_ms > 0 ? "%.0f %% while moving" : "%.0f %% at first",
                                 100 * content.scale * content.scale),
                       -1, 11});
  figures.push_back({"view", std::string(content.show), -1, 9});
  figures.push_back(
      {"camera", nameOf(content.camera) + (content.settings.parallel ? ", parallel" : ""), -1, 10});
  figures.push_back(
      {"frame", formatted("%.1f ms, upload %.1f ms", content.frame_ms, content.upload_ms), -1, 2});
  return figures;
}

}  // namespace lode::app
