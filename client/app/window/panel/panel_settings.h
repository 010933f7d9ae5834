#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "client/app/window/settings.h"

namespace lode::app {

/// A part of the window that takes the mouse, in the pointer's units from the top left corner.
struct Covered {
  glm::dvec2 from{0}, to{0};

  bool has(const glm::dvec2& point) const noexcept {
    return point.x >= from.x && point.y >= from.y && point.x < to.x && point.y < to.y;
  }
};

/// The settings at the top right. @param settings  changed as the user does. @return where they are.
Covered drawSettings(float margin_px, Settings& settings);

}  // namespace lode::app
