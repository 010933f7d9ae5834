#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "common/codec/model_summary.h"

namespace lode::tiles {

/// A place on Earth, on the ellipsoid WGS 84.
struct GeoPosition {
  double longitude_deg = 0, latitude_deg = 0;
  double height_m = 0;  ///< height above the ellipsoid
};

/// An axis-aligned box in the model frame.
struct ModelBox {
  glm::dvec3 centre{0}, half{0};
};

/// Converts a box to the model frame. Half extents are at least half a step, because viewers need boxes with
/// a volume. An empty box becomes a box around the origin.
ModelBox toModelBox(const LatticeBox& box, double step);

/// Returns the transform of a tileset's root: from the model frame to a frame whose z axis is up. Without a
/// place, rotates the file's coordinates so that the model's up axis becomes z. With a place, returns
/// Earth-centred coordinates in metres: the centre of the base of the model's box is at the place, and the
/// model's right points east.
/// @param up  one of the six axis directions.
glm::dmat4 rootTransform(const ModelSummary& model, const glm::dvec3& up,
                         const std::optional<GeoPosition>& at);

}  // namespace lode::tiles
