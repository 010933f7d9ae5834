#include "client/app/window/panel/panel_window.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <imgui.h>

namespace lode::app {
namespace {

constexpr double kLinesPerStep = 3;
constexpr float kTolerancePx = 3;  ///< tolerance for errors in the estimated height of a window

}  // namespace

float fittingPx(float width_px) {
  const float sides_px = 2 * (kPanelMarginPx + ImGui::GetStyle().WindowPadding.x);
  return std::clamp(width_px, 1.0f, std::max(1.0f, ImGui::GetIO().DisplaySize.x - sides_px));
}

void nameRow(const char* name) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextColored(kMuted, "%s", name);
  ImGui::TableNextColumn();
}

void PanelScroll::limit() {
  const float most_px = std::max(1.0f, ImGui::GetIO().DisplaySize.y - 2 * kPanelMarginPx + kTolerancePx);
  ImGui::SetNextWindowSizeConstraints({0, 0}, {std::numeric_limits<float>::max(), most_px});
}

void PanelScroll::follow() {
  const double turned_px = std::exchange(steps_, 0) * kLinesPerStep * ImGui::GetTextLineHeightWithSpacing();
  const float most_px = ImGui::GetScrollMaxY();
  if (turned_px != 0)
    ImGui::SetScrollY(std::clamp(ImGui::GetScrollY() - static_cast<float>(turned_px), 0.0f, most_px));
  where_.reset();
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  if (most_px > 0) where_ = {{at.x, at.y}, {at.x + size.x, at.y + size.y}};
}

}  // namespace lode::app
