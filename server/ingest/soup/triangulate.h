#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Cuts a polygon, convex or not, into corners.size() - 2 triangles by ear clipping. Projects the polygon
/// along the axis that is closest to the normal of its best-fit plane; projects a quad along the normal
/// itself. Keeps the orientation. The result includes triangles without area, so that exactly one triangle
/// uses each edge of the outline. Cuts a polygon arbitrarily if it is not simple, has no area, or exceeds a
/// limit of steps per corner.
/// @param corners    at least 3 positions, in order.
/// @param triangles  receives corner indices; the function clears the vector first.
/// Source: Meisters, Polygons Have Ears, 1975.
void triangulate(std::span<const glm::dvec3> corners, std::vector<glm::u32vec3>& triangles);

}  // namespace lode::ingest
