#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/passes/color_mode.h"

namespace lode::app {

/// Returns the panel's maximal width in a window: the model must stay visible beside it. Pure.
/// @param em_px  font size.
float panelWidthPx(float window_px, float em_px);

/// Returns the share of a window's width, from the left, that the panel covers and beside which a model is
/// framed; 0 if too little is left beside the panel. Pure.
double coveredShare(glm::vec2 window_px, float em_px);

/// A part that the panel may drop if the window is too low.
struct PanelPart {
  int rank = 0;  ///< parts with higher ranks are dropped first
  float height_px = 0;
};

/// Returns which parts fit: by rank, up to the first that does not. Pure.
std::vector<bool> partsThatFit(std::span<const PanelPart> parts, float room_px);

/// Shortens a legend to half of the room, but at least three rows; the last row counts the entries dropped.
/// Pure.
std::vector<render::LegendEntry> legendThatFits(std::span<const render::LegendEntry> legend, float row_px,
                                                float room_px);

}  // namespace lode::app
