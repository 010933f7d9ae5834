#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "common/codec/blob.h"
#include "common/node_key.h"
#include "proto/messages.h"

namespace lode::core {

/// Identifies one mesh of a model.
struct MeshKey {
  NodeKey node;
  uint32_t lod = 0;
  friend constexpr auto operator<=>(const MeshKey&, const MeshKey&) = default;
};

enum class BlobKind : uint8_t { kMesh, kPage, kRootPage, kTextureSet, kTile };

/// Purpose of a requested blob. The session returns the purpose with the blob or the refusal.
struct BlobUse {
  BlobKind kind = BlobKind::kMesh;
  MeshKey mesh;  ///< mesh of a payload; for a page, the page's owner node and LOD 0

  friend constexpr auto operator<=>(const BlobUse&, const BlobUse&) = default;
};

/// Numbers of open requests by class. `tiles` is the number of requests for texture tiles, in all classes.
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

/// A blob that a view needs.
struct Request {
  BlobRef blob = {};
  BlobUse use = {};
  proto::RequestClass request_class = proto::RequestClass::kVisible;
  float priority_px = 0;     ///< projected error that the blob helps to remove
  bool is_stand_in = false;  ///< the mesh is shown only until the wanted meshes below its node are resident
};

/// Merges the requests of several views. The result contains each BlobUse once, with its best class and the
/// highest priority in that class, and is sorted best first.
std::vector<Request> mergeRequests(std::span<const std::vector<Request>> requests);

}  // namespace lode::core
