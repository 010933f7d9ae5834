#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/passes/color_mode.h"

namespace lode::app {

/// Returns the largest width of the panel in a window. The limit keeps the model visible beside the panel.
/// Pure.
/// @param em_px  size of the font.
float panelWidthPx(float window_px, float em_px);

/// Returns the share of a window's width that the panel covers at the left; models are framed in the rest.
/// Returns 0 if the rest is too narrow for a model. Pure.
double coveredShare(glm::vec2 window_px, float em_px);

/// A part that the panel drops if the window is too low.
struct PanelPart {
  int rank = 0;  ///< order in which parts are dropped; parts with higher ranks go first
  float height_px = 0;
};

/// Returns true for each part that fits into the room. Adds parts by rank until one does not fit. Pure.
std::vector<bool> partsThatFit(std::span<const PanelPart> parts, float room_px);

/// Shortens a legend to half of the room, but to no less than three rows. The last row then tells the number
/// of dropped entries. Pure.
std::vector<render::LegendEntry> legendThatFits(std::span<const render::LegendEntry> legend, float row_px,
                                                float room_px);

}  // namespace lode::app
