#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "client/app/window/settings.h"

namespace lode::app {

/// An area of the window that captures the mouse, in pointer units from the top left corner.
struct Covered {
  glm::dvec2 from{0}, to{0};

  bool has(const glm::dvec2& point) const noexcept {
    return point.x >= from.x && point.y >= from.y && point.x < to.x && point.y < to.y;
  }
};

/// Returns the width of the settings in the current window.
float settingsWidthPx(float margin_px);

/// Draws the settings at the top right of the window.
/// @param settings  settings to show; user input changes them. @return the area that the settings cover.
Covered drawSettings(float margin_px, Settings& settings);

}  // namespace lode::app
