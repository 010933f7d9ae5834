#pragma once

#include <cstdint>

#include "client/core/mesh_key.h"
#include "common/blob.h"
#include "proto/messages.h"

namespace lode::core {

enum class BlobKind : uint8_t { kMesh, kPage, kRootPage, kTextureSet, kTile };

/// What a blob is wished for. Travels with the wish and comes back with its ending.
struct BlobUse {
  BlobKind kind = BlobKind::kMesh;
  MeshKey mesh;  ///< of a page: the node that owns it, LOD 0

  friend constexpr auto operator<=>(const BlobUse&, const BlobUse&) = default;
};

/// How many of the wishes that a server has are of each class, and for tiles of textures.
struct WishCounts {
  uint64_t visible = 0, margin = 0, prefetch = 0;
  uint64_t tiles = 0;

  uint64_t& operator[](proto::WishClass wish_class) noexcept {
    if (wish_class == proto::WishClass::kVisible) return visible;
    return wish_class == proto::WishClass::kMargin ? margin : prefetch;
  }
  WishCounts& operator+=(const WishCounts& other) noexcept {
    visible += other.visible;
    margin += other.margin;
    prefetch += other.prefetch;
    tiles += other.tiles;
    return *this;
  }
  friend bool operator==(const WishCounts&, const WishCounts&) = default;
};

/// A blob that a view asks for.
struct Wish {
  BlobRef blob = {};
  BlobUse use = {};
  proto::WishClass wish_class = proto::WishClass::kVisible;
  float priority_px = 0;     ///< error in the picture that its arrival helps to remove
  bool is_stand_in = false;  ///< shown until what is asked for in its place is there
};

}  // namespace lode::core
