#include "client/app/window/panel/panel_frame.h"

#include <algorithm>

namespace lode::app {

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

}  // namespace lode::app
