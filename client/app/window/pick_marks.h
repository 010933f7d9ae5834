#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/app/window/picks.h"
#include "client/core/picture_place.h"

namespace lode::app {

/// Where what is measured shows in a picture.
struct PickMarks {
  std::vector<glm::dvec2> points_px;      ///< of those in front of the eye
  std::optional<core::PictureLine> line;  ///< between two points,
  std::string distance;                   ///< and how long it is

  bool operator==(const PickMarks&) const = default;
};

PickMarks marksOf(const Picks& picks, const core::View& view);

}  // namespace lode::app
