#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/passes/color_mode.h"

namespace lode::app {

/// Returns the width of the panel in a window. The width is limited, so that the model stays visible beside
/// the panel. Pure.
/// @param em_px  font size.
float panelWidthPx(float window_px, float em_px);

/// Returns the share of a window's width that the panel covers at the left; models are framed in the rest.
/// Returns 0 if the rest is too narrow for a model. Pure.
double coveredShare(glm::vec2 window_px, float em_px);

/// Returns true if two windows fit beside each other into a width, with margins around both. Pure.
bool fitSideBySide(float left_px, float right_px, float margin_px, float window_px) noexcept;

/// A part of the panel. If the window is not tall enough for all parts, some are moved to the end of the
/// panel.
struct PanelPart {
  int rank = 0;  ///< parts with smaller ranks get the room first
  float height_px = 0;
};

/// Returns for each part whether it fits into the room. Adds parts in order of rank until one does not fit.
/// Pure.
std::vector<bool> partsThatFit(std::span<const PanelPart> parts, float room_px);

/// Shortens a legend to the number of rows that fit into half of the room, but not to fewer than three rows.
/// The last row of a shortened legend tells the number of left-out entries. Pure.
std::vector<render::LegendEntry> legendThatFits(std::span<const render::LegendEntry> legend, float row_px,
                                                float room_px);

}  // namespace lode::app
