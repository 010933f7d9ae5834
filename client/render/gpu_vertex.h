#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "common/mesh.h"

namespace lode::render {

/// A vertex as the GPU keeps it.
struct GpuVertex {
  uint32_t position_low;   ///< bits 0..31 of the position code
  uint32_t position_high;  ///< bits 32..62
  uint32_t normal;         ///< signed 10:10:10:2, x lowest
  glm::u8vec4 colour;      ///< sRGB, alpha
};
static_assert(sizeof(GpuVertex) == 16);

/// Bytes that a mesh takes on the GPU: its vertices, then its indices, 32 bits each.
uint64_t gpuBytes(const Mesh& mesh) noexcept;

/// Packs vertices [first, first + out.size()) of a mesh.
void packVertices(const Mesh& mesh, size_t first, std::span<GpuVertex> out);

/// True if the mesh brings normals to shade with, its own or computed ones.
constexpr bool hasNormals(AttributeSet attributes) noexcept {
  return attributes.has(AttributeSet::kNormal | AttributeSet::kComputedNormal);
}

}  // namespace lode::render
