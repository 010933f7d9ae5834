#pragma once

#include <imgui.h>

#include "client/app/window/panel/pick_marks.h"

namespace lode::app {

/// Over the picture and below the panel, within a frame of ImGui's; a dark rim keeps them legible on every
/// model.
void drawMarks(const PickMarks& marks, const ImVec4& colour);

}  // namespace lode::app
