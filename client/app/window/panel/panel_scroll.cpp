#include "client/app/window/panel/panel_scroll.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <imgui.h>

#include "client/app/window/panel/panel_frame.h"

namespace lode::app {
namespace {

constexpr double kLinesAStep = 3;
constexpr float kTolerancePx = 3;  ///< by which a window may be higher than it was reckoned to be

}  // namespace

void PanelScroll::limit() {
  const float most_px = std::max(1.0f, ImGui::GetIO().DisplaySize.y - 2 * kPanelMarginPx + kTolerancePx);
  ImGui::SetNextWindowSizeConstraints({0, 0}, {std::numeric_limits<float>::max(), most_px});
}

void PanelScroll::follow() {
  const double turned_px = std::exchange(steps_, 0) * kLinesAStep * ImGui::GetTextLineHeightWithSpacing();
  const float most_px = ImGui::GetScrollMaxY();
  if (turned_px != 0)
    ImGui::SetScrollY(std::clamp(ImGui::GetScrollY() - static_cast<float>(turned_px), 0.0f, most_px));
  where_.reset();
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  if (most_px > 0) where_ = {{at.x, at.y}, {at.x + size.x, at.y + size.y}};
}

}  // namespace lode::app
