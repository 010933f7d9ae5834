#pragma once

namespace lode::app {

/// The size of the panel's letters at a scale of 1.
constexpr float kTextPx = 15;

/// Gives Dear ImGui its typeface and spaces for a scale: DejaVu Sans where the system has it, its own letters
/// otherwise. Between frames, with ImGui's OpenGL backend at work.
void setPanelScale(float scale);

}  // namespace lode::app
