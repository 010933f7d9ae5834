#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "client/render/shown_colours.h"

namespace lode::app {

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
