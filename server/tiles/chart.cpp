#include "server/tiles/chart.h"

#include <array>
#include <cmath>

#include "common/groups.h"

namespace lode::tiles {
namespace {

void addTriangle(Chart& chart, const std::array<glm::dvec2, 3>& uv, const std::array<glm::dvec3, 3>& corner) {
  const glm::dvec2 u = uv[1] - uv[0], v = uv[2] - uv[0];
  chart.area_uv += std::abs(u.x * v.y - u.y * v.x) / 2;
  chart.area_model += glm::length(glm::cross(corner[1] - corner[0], corner[2] - corner[0])) / 2;
}

}  // namespace

Charts findCharts(const Mesh& mesh, const TextureSet& textures, double step) {
  constexpr auto kNone = static_cast<uint32_t>(-1);
  Groups groups(mesh.positions.size());
  for (const glm::u32vec3 t : mesh.triangles) {
    groups.join(t.x, t.y);
    groups.join(t.x, t.z);
  }
  Charts result;
  result.of_vertex.assign(mesh.positions.size(), kNone);
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const VertexAttributes& vertex = mesh.vertex_attributes[v];
    const glm::dvec2 uv = trueTextureCoordinates(textures, vertex);
    const uint32_t first = groups.find(v);  // first <= v, so its chart exists
    if (first == v) {
      result.of_vertex[v] = static_cast<uint32_t>(result.charts.size());
      const bool has_materials = mesh.attributes.has(AttributeSet::kMaterial);
      result.charts.push_back({has_materials ? vertex.material : uint16_t{0}, uv, uv});
    }
    Chart& chart = result.charts[result.of_vertex[v] = result.of_vertex[first]];
    chart.least = glm::min(chart.least, uv);
    chart.most = glm::max(chart.most, uv);
  }
  for (const glm::u32vec3 t : mesh.triangles) {
    std::array<glm::dvec2, 3> uv;
    std::array<glm::dvec3, 3> corner;
    for (int k = 0; k < 3; ++k) {
      uv[k] = trueTextureCoordinates(textures, mesh.vertex_attributes[t[k]]);
      corner[k] = glm::dvec3(unpackPosition(mesh.positions[t[k]])) * step;
    }
    addTriangle(result.charts[result.of_vertex[t.x]], uv, corner);
  }
  return result;
}

}  // namespace lode::tiles
