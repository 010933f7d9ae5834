#pragma once

#include <optional>

#include <imgui.h>

#include "client/app/window/panel/panel_settings.h"

namespace lode::app {

// Constants and functions that the windows of the panel share.

constexpr ImGuiWindowFlags kPlainWindow =
    ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
    ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs;
constexpr float kPanelMarginPx = 12;
inline const ImVec4 kMuted(0.62f, 0.66f, 0.72f, 1), kGood(0.55f, 0.85f, 0.60f, 1),
    kWarning(1.0f, 0.72f, 0.40f, 1), kBad(1.0f, 0.50f, 0.45f, 1), kBar(0.26f, 0.48f, 0.72f, 1);

/// Returns the width, but at most the width of the display minus padding and margins.
float fittingPx(float width_px);

/// Starts a table row with a name in the colour kMuted and moves on to the next column.
void nameRow(const char* name);

/// Scrolls a panel window by the mouse wheel if its content is taller than the display.
class PanelScroll {
 public:
  /// Requests scrolling at the next layout. @param steps  number of wheel steps, positive to scroll up.
  void turn(double steps) noexcept { steps_ += steps; }
  /// Limits the height of the next window to the display. Call it before ImGui::Begin().
  static void limit();
  /// Applies the requested scrolling. Call it before ImGui::End().
  void follow();
  /// Resets the scrolling. Call it instead of follow() if the window is not shown.
  void leaveOut() noexcept { *this = {}; }
  /// Returns the area that captures the wheel; nothing if the whole content fits the display.
  const std::optional<Covered>& where() const noexcept { return where_; }

 private:
  double steps_ = 0;
  std::optional<Covered> where_;
};

}  // namespace lode::app
