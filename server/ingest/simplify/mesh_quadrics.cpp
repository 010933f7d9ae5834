#include "server/ingest/simplify/mesh_quadrics.h"

#include <array>
#include <vector>

namespace lode::ingest {

namespace {

// Weights beside a triangle's plane, which has its area.
constexpr double kPointWeight = 1e-6;  // of a triangle's corners: keeps optima on flat ground and orders them
constexpr double kBoundaryWeight = 2;  // of the plane through a boundary, by the square of the edge's length
constexpr double kSeamWeight = 1;      // the same at an attribute seam

std::array<uint32_t, 3> cornersOf(const CollapseMesh& mesh, uint32_t corner) {
  const uint32_t first = corner & ~3u;
  return {mesh.at(first), mesh.at(first + 1), mesh.at(first + 2)};
}

glm::dvec3 normalOf(const CollapseMesh& mesh, const std::array<uint32_t, 3>& t) {
  return glm::cross(mesh.point(t[1]) - mesh.point(t[0]), mesh.point(t[2]) - mesh.point(t[0]));
}

}  // namespace

void addPlanes(CollapseMesh& mesh) {
  std::vector<double> areas(mesh.positions.size());
  for (uint32_t c = 0; c < mesh.corner_position.size(); c += 4) {
    const std::array<uint32_t, 3> t = cornersOf(mesh, c);
    const glm::dvec3 normal = normalOf(mesh, t);
    const double length = glm::length(normal);
    if (length == 0) continue;
    Quadric plane;
    plane.addPlane(normal, -glm::dot(normal, mesh.point(t[0])), 0.5 / length);  // of unit normals: the area
    for (const uint32_t i : t) {
      mesh.quadrics[i] += plane;
      areas[i] += 0.5 * length;
    }
  }
  for (uint32_t i = 0; i < areas.size(); ++i) {
    mesh.quadrics[i].addPoint(mesh.point(i), kPointWeight * areas[i]);
    mesh.areas[i] = static_cast<float>(areas[i]);
  }
}

void addFeature(CollapseMesh& mesh, const CollapseMesh::Edge& edge) {
  const EdgeKind kind = edge.kind();
  if (kind == EdgeKind::kSmooth) return;
  if (mesh.positions[edge.u].locked && mesh.positions[edge.v].locked) return;
  const glm::dvec3 along = mesh.point(edge.v) - mesh.point(edge.u);
  const glm::dvec3 across = glm::cross(along, normalOf(mesh, cornersOf(mesh, edge.corner)));
  const double length = glm::length(across);
  if (length == 0) return;
  const double weight = kind == EdgeKind::kBoundary ? kBoundaryWeight : kSeamWeight;
  const glm::dvec3 unit = across / length;
  Quadric plane;
  plane.addPlane(unit, -glm::dot(unit, mesh.point(edge.u)), weight * glm::dot(along, along));
  mesh.quadrics[edge.u] += plane;
  mesh.quadrics[edge.v] += plane;
}

}  // namespace lode::ingest
