#pragma once

#include <string>
#include <vector>

#include "client/app/window/panel/panel_content.h"

namespace lode::app {

/// A line of the panel's table.
struct Figure {
  const char* name = "";
  std::string value;
  double part = -1;  ///< of a bar behind it, 0 to 1; below: there is none
  int rank = 0;      ///< the lower, the longer it stays where a window has no room for all

  bool operator==(const Figure&) const = default;
};

/// What the panel's table says, in its order. Pure.
std::vector<Figure> figuresOf(const PanelContent& content);

}  // namespace lode::app
