#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "client/core/lod/request.h"
#include "client/core/textures/texture_footprint.h"
#include "common/limits.h"
#include "common/mesh.h"

namespace lode::core {

/// Returns the main memory that a decoded mesh takes, in bytes.
uint64_t meshBytes(const Mesh& mesh) noexcept;
/// Returns the main memory that a mesh will take once it is decoded, including the cluster boxes that
/// clusterTriangles() adds.
uint64_t meshBytes(uint64_t vertices, uint64_t triangles, AttributeSet attributes) noexcept;

// Bytes that the elements of a mesh take on the GPU.
constexpr uint64_t kDrawnVertexBytes = 16;
constexpr uint64_t kDrawnTexturedVertexBytes = 24;  ///< size of a vertex with texture coordinates
constexpr uint64_t kDrawnTriangleBytes = 12;
/// Size of the bounding box of a cluster of kClusterTriangles triangles.
constexpr uint64_t kDrawnClusterBytes = 24;

/// Returns the GPU memory that a mesh takes, in bytes. Refinement has a separate budget for it, because a
/// mesh without attributes takes more memory on the GPU than in main memory.
constexpr uint64_t drawnBytes(uint64_t vertices, uint64_t triangles, AttributeSet attributes) noexcept {
  const bool is_textured = attributes.has(AttributeSet::kTexture);
  return vertices * (is_textured ? kDrawnTexturedVertexBytes : kDrawnVertexBytes) +
         triangles * kDrawnTriangleBytes + clusterCount(triangles) * kDrawnClusterBytes;
}

inline uint64_t drawnBytes(const Mesh& mesh) noexcept {
  return drawnBytes(mesh.positions.size(), mesh.triangles.size(), mesh.attributes);
}

/// Caches decoded meshes and their texture footprints within a memory budget. Never evicts pinned meshes or
/// meshes in use: those of the cut, and those that can be shown once their siblings are resident. Evicts the
/// others least recently used first; among meshes last used in the same round, deeper nodes go first. Not
/// thread safe.
class MeshCache {
  struct Entry {
    uint32_t lod = 0;
    bool pinned = false;
    std::shared_ptr<const Mesh> mesh;
    std::shared_ptr<const TextureFootprint> footprint;
    uint64_t used_round = 0;
    uint64_t in_use_round = 0;
  };

 public:
  /// The resident LODs of one node.
  class Lods {
   public:
    bool has(uint32_t lod) const noexcept { return (resident_ >> lod & 1) != 0; }
    bool any() const noexcept { return resident_ != 0; }
    /// Returns the coarsest resident LOD. Requires any().
    uint32_t coarsest() const noexcept { return static_cast<uint32_t>(std::bit_width(resident_)) - 1; }
    /// @return null if the mesh is not resident.
    std::shared_ptr<const Mesh> mesh(uint32_t lod) const noexcept;

   private:
    friend class MeshCache;
    const Entry* find(uint32_t lod) const noexcept;
    uint64_t resident_ = 0;  // bit i is set if LOD i is resident
    std::vector<Entry> entries_;
  };
  static_assert(kMaxLods <= 64);

  explicit MeshCache(uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// Adds a mesh. Does nothing if a mesh with this key is already resident.
  /// @param footprint  footprint of a textured mesh; setFootprint() can add the footprint later.
  void insert(MeshKey key, std::shared_ptr<const Mesh> mesh,
              std::shared_ptr<const TextureFootprint> footprint = nullptr);
  void setFootprint(MeshKey key, std::shared_ptr<const TextureFootprint> footprint);
  void pin(MeshKey key);
  /// Returns the resident LODs of a node. Faster than contains() if the caller tests several LODs. The
  /// reference is valid until the cache changes.
  const Lods& lodsOf(NodeKey node) const noexcept;
  /// @return null if the mesh is not resident.
  std::shared_ptr<const Mesh> find(MeshKey key) const noexcept { return lodsOf(key.node).mesh(key.lod); }
  bool contains(MeshKey key) const noexcept { return lodsOf(key.node).has(key.lod); }
  /// @return null if the mesh is not resident or its footprint is unknown.
  const TextureFootprint* footprint(MeshKey key) const noexcept;

  /// Starts a new round of use.
  /// @param in_use    meshes that must stay until the next call.
  /// @param recently  meshes that may be evicted, but only after all meshes that were used less recently.
  /// @return memory of the resident meshes in use, each mesh counted once.
  uint64_t use(std::span<const MeshKey> in_use, std::span<const MeshKey> recently);
  /// Evicts meshes until the rest fits the budget. Never evicts meshes that are in use or pinned.
  void trim();
  /// Sets the budget; it takes effect at the next trim().
  void setBudget(uint64_t bytes) noexcept { budget_bytes_ = bytes; }

  /// Returns the memory of all resident meshes and footprints.
  uint64_t bytes() const noexcept { return bytes_; }
  uint64_t budgetBytes() const noexcept { return budget_bytes_; }
  size_t size() const noexcept { return size_; }

 private:
  struct KeyHash {
    size_t operator()(uint64_t key) const noexcept {
      return static_cast<size_t>(key * 0x9e3779b97f4a7c15ull >> 7);
    }
  };
  static uint64_t bytesOf(const Entry& entry) noexcept;
  Entry* entryOf(MeshKey key) noexcept;
  void evict(MeshKey key);

  uint64_t budget_bytes_;
  uint64_t bytes_ = 0;
  uint64_t round_ = 1;
  size_t size_ = 0;
  std::unordered_map<uint64_t, Lods, KeyHash> nodes_;  // keyed by NodeKey::value
};

}  // namespace lode::core
