#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Cuts a polygon, convex or not, into corners.size() - 2 triangles by ear clipping in its best-fit plane;
/// orientation is kept, and no triangle is left out even where ears are flat, so that the outline's edges are
/// all used once.
/// @param corners    positions in order, >= 3.
/// @param triangles  receives corner numbers 0..corners.size()-1; cleared first.
/// Source: Meisters, Polygons Have Ears, 1975.
void triangulate(std::span<const glm::dvec3> corners, std::vector<glm::u32vec3>& triangles);

}  // namespace lode::ingest
