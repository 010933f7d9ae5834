#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Cuts a polygon, convex or not, into corners.size() - 2 triangles by ear clipping. Projects along the axis
/// nearest to the normal of the best-fit plane (a quad: along the normal). Keeps the orientation and emits
/// flat ears too, so that every edge of the outline is used once. Polygons that are not simple or have no
/// area are cut arbitrarily; so are those that exceed a bound of steps per corner.
/// @param corners    positions in order, at least 3.
/// @param triangles  receives corner indices; cleared first.
/// Source: Meisters, Polygons Have Ears, 1975.
void triangulate(std::span<const glm::dvec3> corners, std::vector<glm::u32vec3>& triangles);

}  // namespace lode::ingest
