#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <vector>

#include <glm/glm.hpp>

#include "common/lattice.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::test {

/// A closed model with intended sharp edges. Faces are triangles, counter-clockwise seen from outside.
struct MachinePart {
  std::vector<glm::dvec3> positions;
  std::vector<glm::u32vec3> triangles;
};

inline MachinePart makeTetrahedron() {
  return {{{0.013, 0.021, 0.007}, {1.017, 0.011, 0.003}, {0.507, 0.871, 0.009}, {0.503, 0.291, 0.823}},
          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

/// Makes a square box of side 4 and height 1 with a bore of radius 0.9. The surface is a grid that is closed
/// in both directions: around the bore, and from the bore over the top, the side and the bottom back into the
/// bore.
/// @param around  number of quads around the bore; a multiple of 8, so that the box has corners. @param rings
/// number of rings of quads on each of the four surfaces.
inline MachinePart makeBoredBox(uint32_t around, uint32_t rings) {
  MachinePart part;
  for (uint32_t i = 0; i < around; ++i) {
    const double angle = 2 * std::numbers::pi * i / around;
    const glm::dvec2 ray(std::cos(angle), std::sin(angle));
    const glm::dvec2 inner = 0.9 * ray, outer = ray * (2 / std::max(std::abs(ray.x), std::abs(ray.y)));
    for (uint32_t j = 0; j < 4 * rings; ++j) {
      const double t = static_cast<double>(j % rings) / rings;
      const glm::dvec3 places[] = {
          {glm::mix(inner, outer, t), 1}, {outer, 1 - t}, {glm::mix(outer, inner, t), 0}, {inner, t}};
      part.positions.push_back(places[j / rings]);
    }
  }
  const auto at = [&](uint32_t i, uint32_t j) { return i % around * 4 * rings + j % (4 * rings); };
  for (uint32_t i = 0; i < around; ++i)
    for (uint32_t j = 0; j < 4 * rings; ++j) {
      part.triangles.emplace_back(at(i, j), at(i, j + 1), at(i + 1, j + 1));
      part.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i + 1, j));
    }
  return part;
}

/// Makes the cube from 0 to 1, with `cells` x `cells` squares on each side.
inline MachinePart makeCube(uint32_t cells) {
  MachinePart part;
  const uint32_t row = cells + 1;
  std::vector<uint32_t> number(row * row * row, UINT32_MAX);
  const auto at = [&](glm::u32vec3 p) {
    uint32_t& known = number[(p.z * row + p.y) * row + p.x];
    if (known == UINT32_MAX) {
      known = static_cast<uint32_t>(part.positions.size());
      part.positions.push_back(glm::dvec3(p) / static_cast<double>(cells));
    }
    return known;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const uint32_t side : {0u, cells})
      for (uint32_t u = 0; u < cells; ++u)
        for (uint32_t v = 0; v < cells; ++v) {
          const auto corner = [&](uint32_t du, uint32_t dv) {
            glm::u32vec3 p(side);
            p[(axis + 1) % 3] = u + du;
            p[(axis + 2) % 3] = v + dv;
            return at(p);
          };
          glm::u32vec3 first(corner(0, 0), corner(1, 0), corner(1, 1)),
              second(corner(0, 0), corner(1, 1), corner(0, 1));
          if (side == 0) {
            std::swap(first.y, first.z);
            std::swap(second.y, second.z);
          }
          part.triangles.push_back(first);
          part.triangles.push_back(second);
        }
  return part;
}

inline void writePart(const MachinePart& part, const std::filesystem::path& file) {
  std::ofstream out(file);
  out.precision(17);
  out << "ply\nformat ascii 1.0\nelement vertex " << part.positions.size()
      << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << part.triangles.size()
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const glm::dvec3& p : part.positions) out << p.x << ' ' << p.y << ' ' << p.z << '\n';
  for (const glm::u32vec3& t : part.triangles) out << "3 " << t.x << ' ' << t.y << ' ' << t.z << '\n';
}

/// Converts a part to a node's mesh without attributes. @param scale lattice steps per unit.
inline ingest::NodeMesh nodeOf(const MachinePart& part, double scale) {
  ingest::NodeMesh mesh;
  for (uint32_t i = 0; i < part.positions.size(); ++i) {
    mesh.positions.push_back(packPosition(glm::uvec3(glm::round(scale * (part.positions[i] + 4.0)))));
    mesh.wedge_position.push_back(i);
  }
  mesh.lca_depth.assign(mesh.positions.size(), ingest::kNeverLocked);
  mesh.triangles = part.triangles;
  return mesh;
}

}  // namespace lode::test
