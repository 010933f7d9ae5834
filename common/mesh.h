#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "common/lattice.h"

namespace lode {

/// Attributes of a model's vertices, as bits. All nodes of a model have the same attributes.
struct AttributeSet {
  static constexpr uint8_t kNormal = 1, kColour = 2, kAlpha = 4, kTexture = 8, kMaterial = 16, kAll = 31;
  /// Bit that is set if the build computed the normals because the input file has none.
  static constexpr uint8_t kComputedNormal = 32;
  uint8_t bits = 0;

  bool operator==(const AttributeSet&) const = default;
  constexpr bool has(uint8_t attribute) const noexcept { return (bits & attribute) != 0; }
};

/// Scale of texture coordinates in a payload: coordinate = code * kTextureStep. TextureSet maps codes to true
/// coordinates.
constexpr double kTextureStep = 0x1p-16;

/// Material of a face without a texture. The texnumber of such a face is -1 or out of range.
constexpr uint16_t kNoMaterial = 0xffff;

/// Attributes of one vertex. The build quantizes them once, when it scans the input, on grids that the whole
/// model shares. Fields of absent attributes have their default values, so that equal vertices compare equal.
struct VertexAttributes {
  uint16_t normal = 0;      ///< octahedral code of the normal, see common/codec/octahedral.h
  uint16_t material = 0;    ///< texture number (PLY texnumber), or kNoMaterial
  glm::u8vec4 colour{255};  ///< red, green, blue, alpha
  glm::u16vec2 texture{0};  ///< texture coordinates in steps of kTextureStep

  bool operator==(const VertexAttributes&) const = default;
};
static_assert(sizeof(VertexAttributes) == 12);

/// Number of triangles of a cluster, a run of neighbouring triangles that the renderer culls together. The
/// last cluster of a mesh may have fewer.
constexpr uint32_t kClusterTriangles = 128;

/// Returns the number of clusters of a mesh with this number of triangles.
constexpr uint64_t clusterCount(uint64_t triangles) noexcept {
  return (triangles + kClusterTriangles - 1) / kClusterTriangles;
}

/// The triangles of one LOD of a node, or of a cut. Each vertex is one combination of position and attributes
/// (a "wedge"). At a seam, several vertices share a position.
struct Mesh {
  AttributeSet attributes;
  std::vector<PositionCode> positions;
  std::vector<VertexAttributes> vertex_attributes;  ///< attributes per vertex; empty if `attributes` is empty
  std::vector<glm::u32vec3> triangles;              ///< indices of vertices, counter-clockwise
  /// Bounding boxes of the clusters: one box per kClusterTriangles consecutive triangles. Empty unless the
  /// triangles are sorted into clusters.
  std::vector<LatticeBox> cluster_boxes = {};

  bool operator==(const Mesh&) const = default;
};

}  // namespace lode
