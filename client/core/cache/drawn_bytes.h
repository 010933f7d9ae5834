#pragma once

#include <cstdint>

#include "common/mesh.h"

namespace lode::core {

// What a drawer's copy of a mesh takes of its memory.
constexpr uint64_t kDrawnVertexBytes = 16;
constexpr uint64_t kDrawnTexturedVertexBytes = 24;  ///< with texture coordinates
constexpr uint64_t kDrawnTriangleBytes = 12;
constexpr uint64_t kDrawnClusterBytes = 24;  ///< of kClusterTriangles: where they lie

/// Bytes that a drawer's copy of a mesh takes: whoever decides what is shown counts in them, too, since
/// meshes without attributes take more of a GPU than of the core.
constexpr uint64_t drawnBytes(uint64_t vertices, uint64_t triangles, AttributeSet attributes) noexcept {
  const bool is_textured = attributes.has(AttributeSet::kTexture);
  return vertices * (is_textured ? kDrawnTexturedVertexBytes : kDrawnVertexBytes) +
         triangles * kDrawnTriangleBytes + clusterCount(triangles) * kDrawnClusterBytes;
}

inline uint64_t drawnBytes(const Mesh& mesh) noexcept {
  return drawnBytes(mesh.positions.size(), mesh.triangles.size(), mesh.attributes);
}

}  // namespace lode::core
