#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <glm/glm.hpp>

/// Legal shapes in which very many triangles meet at a vertex, at an edge or at a place.
namespace lode::test {

struct Shape {
  std::vector<glm::vec3> vertices;
  std::vector<std::array<uint32_t, 3>> faces;

  uint32_t add(glm::vec3 vertex) {
    vertices.push_back(vertex);
    return static_cast<uint32_t>(vertices.size() - 1);
  }
};

/// Returns point i of n on a circle. @param waves  number of waves in the height.
inline glm::vec3 onCircle(uint32_t i, uint32_t n, float waves = 0, float radius = 1) {
  const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(n);
  return {radius * std::cos(angle), radius * std::sin(angle), 0.3f * std::sin(waves * angle)};
}

/// A cone, whose tip is a corner of every triangle.
inline Shape makeHub(uint32_t triangles, float waves = 0, float height = 1) {
  Shape shape{{{0, 0, height}}, {}};
  for (uint32_t i = 0; i < triangles; ++i) shape.add(onCircle(i, triangles, waves));
  for (uint32_t i = 0; i < triangles; ++i) shape.faces.push_back({0, 1 + i, 1 + (i + 1) % triangles});
  return shape;
}

/// All triangles share one edge, like the pages of a book.
inline Shape makeBook(uint32_t triangles) {
  Shape shape{{{0, 0, -1}, {0, 0, 1}}, {}};
  for (uint32_t i = 0; i < triangles; ++i)
    shape.faces.push_back({0, 1, shape.add(onCircle(i, triangles, 7))});
  return shape;
}

/// Triangles that share one vertex and nothing else.
inline Shape makeStar(uint32_t triangles) {
  Shape shape{{{0, 0, 0.2f}}, {}};
  for (uint32_t i = 0; i < triangles; ++i) {
    const uint32_t first = shape.add(onCircle(2 * i, 2 * triangles, 7));
    shape.faces.push_back({0, first, shape.add(onCircle(2 * i + 1, 2 * triangles, 7))});
  }
  return shape;
}

/// Copies of one triangle. @param turns_over  true to reverse every second copy.
inline Shape makeStack(uint32_t triangles, bool turns_over) {
  Shape shape{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f}}, {}};
  for (uint32_t i = 0; i < triangles; ++i)
    shape.faces.push_back(turns_over && i % 2 == 1 ? std::array{0u, 2u, 1u} : std::array{0u, 1u, 2u});
  return shape;
}

/// Two combs of long teeth on one line; the teeth of a comb end in one vertex.
inline Shape makeComb(uint32_t triangles) {
  const uint32_t teeth = triangles / 2;
  Shape shape{{{0.5f, 1, 0}, {0.5f, -1, 0.2f}}, {}};
  for (uint32_t i = 0; i <= teeth; ++i) shape.add({static_cast<float>(i) / static_cast<float>(teeth), 0, 0});
  for (uint32_t i = 0; i < teeth; ++i) {
    shape.faces.push_back({0, 2 + i, 3 + i});
    shape.faces.push_back({1, 3 + i, 2 + i});
  }
  return shape;
}

/// Returns n shapes in a row, with a given total number of triangles.
inline Shape makeRow(const std::function<Shape(uint32_t)>& make, uint32_t n, uint32_t triangles) {
  Shape row;
  for (uint32_t i = 0; i < n; ++i) {
    const auto first = static_cast<uint32_t>(row.vertices.size());
    const Shape one = make(triangles / n);
    for (const glm::vec3 vertex : one.vertices) row.add(vertex + glm::vec3(3 * static_cast<float>(i), 0, 0));
    for (const auto& [a, b, c] : one.faces) row.faces.push_back({first + a, first + b, first + c});
  }
  return row;
}

/// A sphere of rings between two poles. All triangles of a polar ring have the pole.
inline Shape makePolarSphere(uint32_t triangles) {
  const auto rings = static_cast<uint32_t>(std::sqrt(triangles / 4.0)), around = 2 * rings;
  Shape shape{{{0, 0, 1}, {0, 0, -1}}, {}};
  const auto at = [&](uint32_t ring, uint32_t i) { return 2 + (ring - 1) * around + i % around; };
  for (uint32_t ring = 1; ring < rings; ++ring) {
    const float down = std::numbers::pi_v<float> * static_cast<float>(ring) / static_cast<float>(rings);
    for (uint32_t i = 0; i < around; ++i) {
      const glm::vec3 on = onCircle(i, around, 0, std::sin(down));
      shape.add({on.x, on.y, std::cos(down)});
    }
  }
  for (uint32_t i = 0; i < around; ++i) {
    shape.faces.push_back({0, at(1, i), at(1, i + 1)});
    for (uint32_t ring = 1; ring + 1 < rings; ++ring) {
      shape.faces.push_back({at(ring, i), at(ring + 1, i), at(ring, i + 1)});
      shape.faces.push_back({at(ring, i + 1), at(ring + 1, i), at(ring + 1, i + 1)});
    }
    shape.faces.push_back({at(rings - 1, i), 1, at(rings - 1, i + 1)});
  }
  return shape;
}

inline void writePly(const Shape& shape, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::binary);
  file << "ply\nformat binary_little_endian 1.0\nelement vertex " << shape.vertices.size()
       << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << shape.faces.size()
       << "\nproperty list uchar uint vertex_indices\nend_header\n";
  file.write(reinterpret_cast<const char*>(shape.vertices.data()),
             static_cast<std::streamsize>(shape.vertices.size() * sizeof(glm::vec3)));
  for (const auto& face : shape.faces) {
    file.put(3);
    file.write(reinterpret_cast<const char*>(face.data()), sizeof face);
  }
}

}  // namespace lode::test
