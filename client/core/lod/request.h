#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "common/codec/blob.h"
#include "common/node_key.h"
#include "proto/messages.h"

namespace lode::core {

/// Names one mesh of a model.
struct MeshKey {
  NodeKey node;
  uint32_t lod = 0;
  friend constexpr auto operator<=>(const MeshKey&, const MeshKey&) = default;
};

enum class BlobKind : uint8_t { kMesh, kPage, kRootPage, kTextureSet, kTile };

/// What a blob is requested. Travels with the request and comes back with its ending.
struct BlobUse {
  BlobKind kind = BlobKind::kMesh;
  MeshKey mesh;  ///< of a page: the node that owns it, LOD 0

  friend constexpr auto operator<=>(const BlobUse&, const BlobUse&) = default;
};

/// How many of the requests that a server has are of each class, and for tiles of textures.
struct RequestCounts {
  uint64_t visible = 0, margin = 0, prefetch = 0;
  uint64_t tiles = 0;

  uint64_t& operator[](proto::RequestClass request_class) noexcept {
    if (request_class == proto::RequestClass::kVisible) return visible;
    return request_class == proto::RequestClass::kMargin ? margin : prefetch;
  }
  RequestCounts& operator+=(const RequestCounts& other) noexcept {
    visible += other.visible;
    margin += other.margin;
    prefetch += other.prefetch;
    tiles += other.tiles;
    return *this;
  }
  friend bool operator==(const RequestCounts&, const RequestCounts&) = default;
};

/// A blob that a view asks for.
struct Request {
  BlobRef blob = {};
  BlobUse use = {};
  proto::RequestClass request_class = proto::RequestClass::kVisible;
  float priority_px = 0;     ///< error in the picture that its arrival helps to remove
  bool is_stand_in = false;  ///< shown until what is asked for in its place is there
};

/// The requests of several views, each blob use once: with the best class and the largest priority that one
/// of them has for it. Best first.
std::vector<Request> mergeRequests(std::span<const std::vector<Request>> requests);

}  // namespace lode::core
