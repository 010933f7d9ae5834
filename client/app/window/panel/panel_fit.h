#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/shown_colours.h"

namespace lode::app {

/// Of a window, at most: beside it the model is to be seen. Pure. @param em_px  the size of a letter.
float panelWidthPx(float window_px, float em_px);

/// Of a window's width, from its left, beside which a model is framed: what the panel covers, or nothing
/// where too little is left beside that. Pure.
double coveredShare(glm::vec2 window_px, float em_px);

/// What the panel may leave out where a window is low.
struct PanelPart {
  int rank = 0;  ///< the lower, the longer it stays
  float height_px = 0;
};

/// Which parts have room: those of the lowest ranks, up to the first that has none. Pure.
std::vector<bool> partsThatFit(std::span<const PanelPart> parts, float room_px);

/// A legend in at most half of the room, and never in less than three rows: the last says how many more there
/// are. Pure.
std::vector<render::LegendEntry> legendThatFits(std::span<const render::LegendEntry> legend, float row_px,
                                                float room_px);

}  // namespace lode::app
