#pragma once

#include <cstddef>
#include <cstring>
#include <span>

#include "common/lattice.h"
#include "common/mesh.h"

namespace lode::ingest {

/// A triangle of the triangle soup, which has no indices: the positions of its corners and, if the model has
/// attributes, their attributes.
struct SoupTriangle {
  PositionCode corners[3];
  VertexAttributes attributes[3];
};

constexpr size_t kSoupPositionBytes = sizeof(SoupTriangle::corners);
constexpr size_t kMaxSoupBytes = kSoupPositionBytes + sizeof(SoupTriangle::attributes);

/// Bytes per triangle in temporary files: 24, or 60 with attributes.
constexpr size_t soupBytes(AttributeSet attributes) noexcept {
  return attributes.bits == 0 ? kSoupPositionBytes : kMaxSoupBytes;
}

inline void storeSoup(const SoupTriangle& triangle, std::span<std::byte> to) noexcept {
  std::memcpy(to.data(), triangle.corners, kSoupPositionBytes);
  if (to.size() > kSoupPositionBytes) {
    std::memcpy(to.data() + kSoupPositionBytes, triangle.attributes, sizeof(triangle.attributes));
  }
}

inline SoupTriangle loadSoup(std::span<const std::byte> from) noexcept {
  SoupTriangle triangle;
  std::memcpy(triangle.corners, from.data(), kSoupPositionBytes);
  if (from.size() > kSoupPositionBytes) {
    std::memcpy(triangle.attributes, from.data() + kSoupPositionBytes, sizeof(triangle.attributes));
  }
  return triangle;
}

}  // namespace lode::ingest
