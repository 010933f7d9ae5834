#pragma once

#include <optional>

#include <imgui.h>

#include "client/app/window/panel/panel_settings.h"

namespace lode::app {

// Shared by the windows of the panel.

constexpr ImGuiWindowFlags kPlainWindow =
    ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
    ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs;
constexpr float kPanelMarginPx = 12;
inline const ImVec4 kMuted(0.62f, 0.66f, 0.72f, 1);

/// Clamps a content width to the display, minus padding and margins.
float fittingPx(float width_px);

/// Starts a table row with a muted name and moves on to the next column.
void nameRow(const char* name);

/// Scrolls a panel window by the mouse wheel if it is higher than the display.
class PanelScroll {
 public:
  /// Scrolls at the next layout. @param steps  wheel steps, forward is up.
  void turn(double steps) noexcept { steps_ += steps; }
  /// Limits the height of the next window to the display. Call it before ImGui::Begin().
  static void limit();
  /// Applies the scrolling. Call it before ImGui::End().
  void follow();
  /// Call it instead of follow() if the window is not shown.
  void leaveOut() noexcept { *this = {}; }
  /// The area that captures the wheel; nothing if the window fits.
  const std::optional<Covered>& where() const noexcept { return where_; }

 private:
  double steps_ = 0;
  std::optional<Covered> where_;
};

}  // namespace lode::app
