#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "common/lattice.h"

namespace lode {

/// Which attributes a model's vertices carry, as bits; the same for all nodes of a model.
struct AttributeSet {
  static constexpr uint8_t kNormal = 1, kColour = 2, kAlpha = 4, kTexture = 8, kMaterial = 16, kAll = 31;
  /// The normals were computed at the build; the input file has none.
  static constexpr uint8_t kComputedNormal = 32;
  uint8_t bits = 0;

  bool operator==(const AttributeSet&) const = default;
  constexpr bool has(uint8_t attribute) const noexcept { return (bits & attribute) != 0; }
};

/// A texture coordinate in a payload is its code times this, so that 1 is within a step of a code; the
/// model's TextureSet says what true coordinate a code is.
constexpr double kTextureStep = 0x1p-16;

/// The material of a face that wears no texture: a texnumber of -1, or one below or beyond all.
constexpr uint16_t kNoMaterial = 0xffff;

/// Attributes of one vertex as quantized once, at the scan, on grids of the whole model. Fields of attributes
/// that the model does not have are zero (colour: white, 255 each), so that equal vertices compare equal.
struct VertexAttributes {
  uint16_t normal = 0;      ///< octahedral, see common/codec/octahedral.h
  uint16_t material = 0;    ///< number of the texture (PLY texnumber), or kNoMaterial
  glm::u8vec4 colour{255};  ///< red, green, blue, alpha
  glm::u16vec2 texture{0};  ///< in steps of kTextureStep

  bool operator==(const VertexAttributes&) const = default;
};
static_assert(sizeof(VertexAttributes) == 12);

constexpr uint32_t kClusterTriangles = 128;

/// Clusters of a mesh of so many triangles.
constexpr uint64_t clusterCount(uint64_t triangles) noexcept {
  return (triangles + kClusterTriangles - 1) / kClusterTriangles;
}

/// Triangles of one (node, LOD), or of a cut. A vertex is one combination of position and attributes
/// ("wedge"); at a seam several vertices share a position.
struct Mesh {
  AttributeSet attributes;
  std::vector<PositionCode> positions;
  std::vector<VertexAttributes> vertex_attributes;  ///< one a vertex, or empty where `attributes` is empty
  std::vector<glm::u32vec3> triangles;              ///< indices of vertices, counter-clockwise
  /// Where each kClusterTriangles triangles lie, in their order; empty where nobody has put near ones
  /// together.
  std::vector<LatticeBox> cluster_boxes = {};

  bool operator==(const Mesh&) const = default;
};

}  // namespace lode
