#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <unordered_map>
#include <vector>

#include <glm/glm.hpp>

namespace lode::test {

/// A gyroid that is open at the sides of its cube. The surface fills the cube, so that nodes have long
/// borders. Made by marching tetrahedra, six per cell.
class PorousSurface {
 public:
  /// @param cells  number of cells along an edge of the cube. @param periods number of the gyroid's periods
  /// along an edge.
  PorousSurface(uint32_t cells, double periods) : side_(cells + 1), scale_(2 * M_PI * periods / cells) {
    for (uint32_t z = 0; z < cells; ++z)
      for (uint32_t y = 0; y < cells; ++y)
        for (uint32_t x = 0; x < cells; ++x) addCell({x, y, z});
  }

  size_t triangles() const noexcept { return triangles_.size(); }

  void write(const std::filesystem::path& ply) const {
    std::ofstream out(ply, std::ios::binary);
    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << points_.size()
        << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << triangles_.size()
        << "\nproperty list uchar int vertex_indices\nend_header\n";
    out.write(reinterpret_cast<const char*>(points_.data()),
              static_cast<std::streamsize>(points_.size() * sizeof(glm::vec3)));
    for (const glm::u32vec3& t : triangles_) {
      out.put(3);
      out.write(reinterpret_cast<const char*>(&t), sizeof t);
    }
  }

 private:
  double valueAt(glm::uvec3 at) const {
    const glm::dvec3 p = glm::dvec3(at) * scale_ + 0.37;
    return std::sin(p.x) * std::cos(p.y) + std::sin(p.y) * std::cos(p.z) + std::sin(p.z) * std::cos(p.x);
  }

  void addCell(glm::uvec3 at) {
    static constexpr std::array<std::array<unsigned, 4>, 6> kTetrahedra{
        {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};
    std::array<double, 8> values;
    for (unsigned i = 0; i < 8; ++i) values[i] = valueAt(at + corner(i));
    if (*std::ranges::max_element(values) < 0 || *std::ranges::min_element(values) >= 0) return;
    for (const auto& tetrahedron : kTetrahedra) {
      std::vector<unsigned> inside, outside;
      for (const unsigned i : tetrahedron) (values[i] < 0 ? inside : outside).push_back(i);
      if (inside.empty() || outside.empty()) continue;
      const auto cut = [&](unsigned a, unsigned b) {
        return vertexOn(at + corner(a), at + corner(b), values[a] / (values[a] - values[b]));
      };
      const glm::dvec3 out = glm::dvec3(corner(outside[0])) - glm::dvec3(corner(inside[0]));
      if (inside.size() == 2) {
        const uint32_t a = cut(inside[0], outside[0]), b = cut(inside[0], outside[1]),
                       c = cut(inside[1], outside[1]), d = cut(inside[1], outside[0]);
        addTriangle({a, b, c}, out);
        addTriangle({a, c, d}, out);
      } else {
        const auto& many = inside.size() == 3 ? inside : outside;
        const unsigned one = inside.size() == 3 ? outside[0] : inside[0];
        addTriangle({cut(one, many[0]), cut(one, many[1]), cut(one, many[2])}, out);
      }
    }
  }

  static glm::uvec3 corner(unsigned i) { return {i & 1, i >> 1 & 1, i >> 2}; }

  uint32_t vertexOn(glm::uvec3 a, glm::uvec3 b, double share) {
    uint64_t ends[2];
    for (int i = 0; i < 2; ++i) {
      const glm::u64vec3 p(i == 0 ? a : b);
      ends[i] = (p.z * side_ + p.y) * side_ + p.x;
    }
    if (ends[0] > ends[1]) {
      std::swap(ends[0], ends[1]);
      std::swap(a, b);
      share = 1 - share;
    }
    const auto [known, added] =
        vertices_.emplace(ends[0] << 32 | ends[1], static_cast<uint32_t>(points_.size()));
    if (added) points_.emplace_back(glm::mix(glm::dvec3(a), glm::dvec3(b), std::clamp(share, 0.05, 0.95)));
    return known->second;
  }

  void addTriangle(glm::u32vec3 t, glm::dvec3 out) {
    const glm::dvec3 a(points_[t.x]), b(points_[t.y]), c(points_[t.z]);
    if (glm::dot(glm::cross(b - a, c - a), out) < 0) std::swap(t.y, t.z);
    triangles_.push_back(t);
  }

  const uint64_t side_;
  const double scale_;
  std::unordered_map<uint64_t, uint32_t> vertices_;
  std::vector<glm::vec3> points_;
  std::vector<glm::u32vec3> triangles_;
};

}  // namespace lode::test
