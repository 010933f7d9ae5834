#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Cuts a polygon, convex or not, into corners.size() - 2 triangles by ear clipping. Projects a polygon along
/// the coordinate axis nearest to its normal, and a quad along its normal. The triangles keep the polygon's
/// orientation. The result includes triangles of zero area, so that exactly one triangle uses each edge of
/// the outline. Cuts a polygon arbitrarily if it is not simple, has no area, or exceeds a limit of steps per
/// corner.
/// @param corners    at least 3 positions, in order.
/// @param triangles  receives corner indices; the function clears the vector first.
/// Source: Meisters, Polygons Have Ears, 1975.
void triangulate(std::span<const glm::dvec3> corners, std::vector<glm::u32vec3>& triangles);

}  // namespace lode::ingest
