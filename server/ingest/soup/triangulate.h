#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Cuts a polygon, convex or not, into corners.size() - 2 triangles by ear clipping, seen along the axis that
/// is nearest to the normal of its best-fit plane (a quad: along that normal); orientation is kept, and no
/// triangle is left out even where ears are flat, so that the outline's edges are all used once. A polygon
/// that is not simple, or has no area, is cut too, somehow. The work is bounded by a number of steps a
/// corner; what needs more is not simple.
/// @param corners    positions in order, >= 3.
/// @param triangles  receives corner numbers 0..corners.size()-1; cleared first.
/// Source: Meisters, Polygons Have Ears, 1975.
void triangulate(std::span<const glm::dvec3> corners, std::vector<glm::u32vec3>& triangles);

}  // namespace lode::ingest
