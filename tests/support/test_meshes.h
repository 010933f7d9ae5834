#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "common/codec/octahedral.h"
#include "common/mesh.h"

/// Meshes made from a seed, for the tests of all modules.
namespace lode::test {

struct MeshOptions {
  /// Attributes of the mesh; alpha varies, and textures and materials cause seams.
  AttributeSet attributes;
  uint32_t extent = 1u << 12;  ///< longest side in lattice steps, 1..kMaxLattice
  glm::uvec3 origin{0};        ///< lowest corner of the mesh, in lattice coordinates
  uint32_t seed = 1;           ///< seed of bumps and attributes
  double bump = 0.05;          ///< height of the bumps, as a fraction of the extent
};

/// Returns attributes that depend only on the position and the seed, so that equal positions of different
/// meshes have equal attributes.
inline VertexAttributes attributesAt(glm::uvec3 p, glm::vec3 normal, const MeshOptions& options) {
  VertexAttributes result;
  const AttributeSet set = options.attributes;
  const uint32_t hash = (p.x * 0x9E3779B1u ^ p.y * 0x85EBCA77u ^ p.z * 0xC2B2AE3Du) + options.seed;
  if (set.has(AttributeSet::kNormal)) result.normal = encodeOctahedral(normal);
  if (set.has(AttributeSet::kColour))
    result.colour = glm::u8vec4(p.x >> 4 & 255, p.y >> 4 & 255, ((p.z >> 4) + (hash >> 30)) & 255, 255);
  if (set.has(AttributeSet::kAlpha)) result.colour.a = static_cast<uint8_t>(hash >> 24);
  if (set.has(AttributeSet::kTexture)) result.texture = glm::u16vec2(p.x & 0xffff, p.y & 0xffff);
  return result;
}

/// Makes a bumpy height field of columns x rows quads (two triangles each), open at its boundary. With
/// kMaterial, the left half has material 0 and the right half material 1; the column between has two wedges
/// per position.
inline Mesh makeGrid(uint32_t columns, uint32_t rows, const MeshOptions& options = {}) {
  Mesh mesh;
  mesh.attributes = options.attributes;
  std::mt19937 random(options.seed);
  const uint32_t longest = std::max(columns, rows);
  const double spacing = double(options.extent) / longest;
  const double bump = std::min(options.bump * options.extent, double(kMaxLattice - options.origin.z));
  const bool seam = options.attributes.has(AttributeSet::kMaterial) && columns > 1;
  const uint32_t seam_column = seam ? columns / 2 : columns + 1;
  const uint32_t width = columns + 1 + (seam ? 1 : 0);
  for (uint32_t row = 0; row <= rows; ++row)
    for (uint32_t i = 0; i < width; ++i) {
      const uint32_t column = i > seam_column ? i - 1 : i;
      // Compute the height from the position alone, so that two neighbouring grids agree where they touch.
      const glm::uvec3 p =
          options.origin + glm::uvec3(std::lround(column * spacing), std::lround(row * spacing), 0);
      const double x = p.x / spacing, y = p.y / spacing, phase = options.seed;
      const double height = 0.5 + 0.25 * (std::sin(0.7 * x + phase) + std::sin(0.9 * y + 2 * phase));
      const glm::uvec3 position(p.x, p.y, p.z + static_cast<uint32_t>(height * bump));
      mesh.positions.push_back(packPosition(position));
      const glm::vec3 normal(-std::cos(0.7 * x + phase), -std::cos(0.9 * y + 2 * phase), 2);
      if (options.attributes.bits != 0) {
        mesh.vertex_attributes.push_back(attributesAt(position, normal, options));
        if (i > seam_column) mesh.vertex_attributes.back().material = 1;
      }
    }
  for (uint32_t row = 0; row < rows; ++row)
    for (uint32_t i = 0; i + 1 < width; ++i) {
      if (i == seam_column) continue;
      const uint32_t a = row * width + i, b = a + 1, c = a + width, d = c + 1;
      const bool flip = random() % 2 == 0;
      mesh.triangles.emplace_back(a, b, flip ? d : c);
      mesh.triangles.emplace_back(flip ? a : b, d, c);
    }
  return mesh;
}

/// Makes a closed bumpy sphere of 2 * slices * (stacks - 1) triangles. With kTexture, a seam runs from pole
/// to pole, with two wedges per position. With kMaterial, the lower half has material 1. Requires slices >=
/// 3, stacks >= 2, and an extent that keeps neighbouring vertices distinct.
inline Mesh makeSphere(uint32_t slices, uint32_t stacks, const MeshOptions& options = {}) {
  Mesh mesh;
  mesh.attributes = options.attributes;
  const bool texture = options.attributes.has(AttributeSet::kTexture);
  const bool material = options.attributes.has(AttributeSet::kMaterial);
  const double radius = options.extent / 2.0;
  const double phase = options.seed;
  std::vector<uint32_t> index_of((stacks + 1) * (slices + 1) * 2);
  const auto vertex = [&](uint32_t stack, uint32_t slice, uint16_t number) -> uint32_t {
    if (stack == 0 || stack == stacks) slice = 0;
    if (!texture) slice %= slices;
    uint32_t& index = index_of[(stack * (slices + 1) + slice) * 2 + number];
    if (index != 0) return index - 1;
    const double theta = std::numbers::pi * stack / stacks;
    const double phi = 2 * std::numbers::pi * (slice % slices) / slices;
    const glm::dvec3 direction(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                               std::cos(theta));
    const double bumps = std::sin(5 * theta + phase) * std::sin(6 * phi + 2 * phase) * std::sin(theta);
    const double r = radius * (1 - options.bump * (1 - bumps) / 2);
    const glm::uvec3 p = options.origin + glm::uvec3(glm::round(direction * r + radius));
    mesh.positions.push_back(packPosition(p));
    if (options.attributes.bits != 0) {
      VertexAttributes attributes = attributesAt(p, glm::vec3(direction), options);
      attributes.material = number;
      if (texture) attributes.texture = glm::u16vec2(65535.0 * slice / slices, 65535.0 * stack / stacks);
      mesh.vertex_attributes.push_back(attributes);
    }
    index = static_cast<uint32_t>(mesh.positions.size());
    return index - 1;
  };
  for (uint32_t stack = 0; stack < stacks; ++stack)
    for (uint32_t slice = 0; slice < slices; ++slice) {
      const uint16_t number = material && stack >= stacks / 2 ? 1 : 0;
      const uint32_t a = vertex(stack, slice, number), b = vertex(stack + 1, slice, number);
      const uint32_t c = vertex(stack + 1, slice + 1, number), d = vertex(stack, slice + 1, number);
      if (stack + 1 < stacks) mesh.triangles.emplace_back(a, b, c);
      if (stack > 0) mesh.triangles.emplace_back(a, c, d);
    }
  return mesh;
}

/// Returns the tight box of a mesh's positions.
inline LatticeBox boxOf(const Mesh& mesh) {
  LatticeBox box;
  for (const PositionCode code : mesh.positions) box.add(unpackPosition(code));
  return box;
}

}  // namespace lode::test
