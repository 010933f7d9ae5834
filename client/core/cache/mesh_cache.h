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

/// Bytes that a decoded mesh takes in memory.
uint64_t meshBytes(const Mesh& mesh) noexcept;
/// The same, before it is there, with its clusters: see clusterTriangles().
uint64_t meshBytes(uint64_t vertices, uint64_t triangles, AttributeSet attributes) noexcept;

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

/// The decoded meshes that are resident and their footprints, within a budget. What is in use (the cut and
/// what it waits for) and what is pinned stays; of the rest the least recently used goes first, and of equals
/// the deeper node, so that ancestors go last. Not thread safe.
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
  /// The LODs of one node that are resident.
  class Lods {
   public:
    bool has(uint32_t lod) const noexcept { return (resident_ >> lod & 1) != 0; }
    bool any() const noexcept { return resident_ != 0; }
    /// Where there is any.
    uint32_t coarsest() const noexcept { return static_cast<uint32_t>(std::bit_width(resident_)) - 1; }
    /// @return null if it is not resident.
    std::shared_ptr<const Mesh> mesh(uint32_t lod) const noexcept;

   private:
    friend class MeshCache;
    const Entry* find(uint32_t lod) const noexcept;
    uint64_t resident_ = 0;  // bit r: LOD r
    std::vector<Entry> entries_;
  };
  static_assert(kMaxLods <= 64);

  explicit MeshCache(uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// A mesh that is there already is kept as it is.
  /// @param footprint  of a mesh that wears textures; may come later, with setFootprint().
  void insert(MeshKey key, std::shared_ptr<const Mesh> mesh,
              std::shared_ptr<const TextureFootprint> footprint = nullptr);
  void setFootprint(MeshKey key, std::shared_ptr<const TextureFootprint> footprint);
  void pin(MeshKey key);
  /// Good until the cache changes; for who asks much of one node.
  const Lods& lodsOf(NodeKey node) const noexcept;
  /// @return null if it is not resident.
  std::shared_ptr<const Mesh> find(MeshKey key) const noexcept { return lodsOf(key.node).mesh(key.lod); }
  bool contains(MeshKey key) const noexcept { return lodsOf(key.node).has(key.lod); }
  /// @return null if the mesh is not resident or its footprint is not known.
  const TextureFootprint* footprint(MeshKey key) const noexcept;

  /// Starts a new round of use.
  /// @param in_use    meshes that must stay until the next call.
  /// @param recently  meshes that were looked at: evicted after all that were not.
  /// @return bytes of those in use that are resident, each counted once.
  uint64_t use(std::span<const MeshKey> in_use, std::span<const MeshKey> recently);
  /// Evicts what does not fit the budget, but nothing in use or pinned.
  void trim();
  /// From the next trim() on.
  void setBudget(uint64_t bytes) noexcept { budget_bytes_ = bytes; }

  /// Of meshes and footprints.
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
  std::unordered_map<uint64_t, Lods, KeyHash> nodes_;  // by key value
};

}  // namespace lode::core
