#pragma once

#include "client/app/window/panel/panel_letters.h"

namespace lode::app {

/// The size of the panel's letters at a scale of 1.
constexpr float kTextPx = 15;

/// Gives Dear ImGui its typeface and spaces for a scale: DejaVu Sans where the system has it, its own letters
/// otherwise; and for what that lacks the first of some fonts of East Asia that is there. Between frames,
/// with ImGui's OpenGL backend at work.
void setPanelFont(float scale, const PanelLetters& letters);

}  // namespace lode::app
