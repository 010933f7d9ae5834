#pragma once

#include <string>
#include <vector>

#include "client/app/window/panel/panel_content.h"

namespace lode::app {

/// A row of the panel's table.
struct Figure {
  const char* name = "";
  std::string value;
  double part = -1;  ///< length of the row's bar, 0 to 1; negative: no bar
  /// Rank of the row if the window is not tall enough for all rows: see PanelPart::rank.
  int rank = 0;

  bool operator==(const Figure&) const = default;
};

/// Returns the rows of the panel's table in order. Pure.
std::vector<Figure> figuresOf(const PanelContent& content);

}  // namespace lode::app
