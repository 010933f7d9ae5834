#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "client/core/cache/mesh_cache.h"
#include "common/mesh.h"

namespace lode::render {

/// A vertex in GPU memory, for models without texture coordinates.
struct GpuVertex {
  uint32_t position_low;   ///< bits 0..31 of the position code
  uint32_t position_high;  ///< bits 32..62 of the position code
  uint32_t normal;         ///< normal in signed 10:10:10:2 format, x in the lowest bits
  glm::u8vec4 colour;      ///< sRGB colour and alpha
};
static_assert(sizeof(GpuVertex) == core::kDrawnVertexBytes);

/// A vertex in GPU memory, with texture coordinates.
struct GpuTexturedVertex {
  GpuVertex vertex;
  glm::u16vec2 texture;  ///< quantized texture coordinates
  uint16_t material;
  uint16_t unused;
};
static_assert(sizeof(GpuTexturedVertex) == core::kDrawnTexturedVertexBytes);

/// Returns the size of a vertex of meshes with these attributes.
constexpr uint32_t vertexBytes(AttributeSet attributes) noexcept {
  return attributes.has(AttributeSet::kTexture) ? sizeof(GpuTexturedVertex) : sizeof(GpuVertex);
}

/// Packs vertices of a mesh, starting at `first`, until `out` is full. Each vertex needs
/// vertexBytes(mesh.attributes) bytes.
void packVertices(const Mesh& mesh, size_t first, std::span<std::byte> out);

/// Returns true if meshes with these attributes have vertex normals, from the file or computed.
constexpr bool hasNormals(AttributeSet attributes) noexcept {
  return attributes.has(AttributeSet::kNormal | AttributeSet::kComputedNormal);
}

}  // namespace lode::render
