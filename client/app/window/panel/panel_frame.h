#pragma once

#include <imgui.h>

namespace lode::app {

// What the windows of the panel have in common.

constexpr ImGuiWindowFlags kPlainWindow =
    ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
    ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs;
constexpr float kPanelMarginPx = 12;
inline const ImVec4 kMuted(0.62f, 0.66f, 0.72f, 1);

/// What a window leaves of a width, between its own sides and the panel's.
float fittingPx(float width_px);

/// A row of a table: its name, muted, and in the next column whatever follows.
void nameRow(const char* name);

}  // namespace lode::app
