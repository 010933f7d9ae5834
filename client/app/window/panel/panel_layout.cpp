#include "client/app/window/panel/panel_layout.h"

#include <algorithm>
#include <numeric>
#include <string>

namespace lode::app {
namespace {

constexpr float kPanelEm = 23.5f;
constexpr float kPanelShare = 0.4f;  ///< limit of the panel's width, as a share of the window's width
constexpr float kLeastPanelEm = 11;
constexpr float kSidesEm = 2;         ///< width of the panel's padding and margins, in font sizes
constexpr float kLeastAspect = 0.75;  ///< least aspect ratio of the free area in which a model is framed

constexpr size_t kLeastLegendRows = 3;
constexpr float kShareOfLegend = 0.5f;
constexpr glm::u8vec3 kRestColour{200, 200, 200};

}  // namespace

float panelWidthPx(float window_px, float em_px) {
  return std::min(kPanelEm * em_px, std::max(kPanelShare * window_px, kLeastPanelEm * em_px));
}

double coveredShare(glm::vec2 window_px, float em_px) {
  const float covered_px = panelWidthPx(window_px.x, em_px) + kSidesEm * em_px;
  const bool is_enough = window_px.x - covered_px >= kLeastAspect * window_px.y;
  return is_enough ? static_cast<double>(covered_px / window_px.x) : 0;
}

bool fitSideBySide(float left_px, float right_px, float margin_px, float window_px) noexcept {
  return left_px + right_px + 3 * margin_px <= window_px;
}

std::vector<bool> partsThatFit(std::span<const PanelPart> parts, float room_px) {
  std::vector<size_t> by_rank(parts.size());
  std::iota(by_rank.begin(), by_rank.end(), size_t{0});
  std::ranges::stable_sort(by_rank, {}, [&](size_t i) { return parts[i].rank; });
  std::vector<bool> fit(parts.size(), false);
  for (const size_t i : by_rank) {
    room_px -= parts[i].height_px;
    if (room_px < 0) break;
    fit[i] = true;
  }
  return fit;
}

std::vector<render::LegendEntry> legendThatFits(std::span<const render::LegendEntry> legend, float row_px,
                                                float room_px) {
  const auto rows = static_cast<size_t>(std::max(0.0f, kShareOfLegend * room_px / std::max(row_px, 1.0f)));
  const size_t most = std::max(kLeastLegendRows, rows);
  if (legend.size() <= most) return {legend.begin(), legend.end()};
  std::vector<render::LegendEntry> shown(legend.begin(), legend.begin() + static_cast<ptrdiff_t>(most) - 1);
  uint64_t more = 0;
  for (const render::LegendEntry& entry : legend.subspan(most - 1)) more += entry.stands_for;
  shown.push_back({kRestColour, "and " + std::to_string(more) + " more"});
  return shown;
}

}  // namespace lode::app
