#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "client/core/mesh_key.h"
#include "client/core/texture_footprint.h"
#include "common/mesh.h"

namespace lode::core {

/// Bytes that a decoded mesh takes in memory.
uint64_t meshBytes(const Mesh& mesh) noexcept;
/// The same, before it is there.
uint64_t meshBytes(uint64_t vertices, uint64_t triangles, AttributeSet attributes) noexcept;

/// The decoded meshes that are resident and their footprints, within a budget. What is in use (the cut and
/// what it waits for) and what is pinned stays; of the rest the least recently used goes first, and of equals
/// the deeper node, so that ancestors go last. Not thread safe.
class MeshCache {
 public:
  explicit MeshCache(uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// A mesh that is there already is kept as it is.
  /// @param footprint  of a mesh that wears textures; may come later, with setFootprint().
  void insert(MeshKey key, std::shared_ptr<const Mesh> mesh,
              std::shared_ptr<const TextureFootprint> footprint = nullptr);
  void setFootprint(MeshKey key, std::shared_ptr<const TextureFootprint> footprint);
  void pin(MeshKey key);
  /// @return null if it is not resident.
  std::shared_ptr<const Mesh> find(MeshKey key) const noexcept;
  /// @return null if the mesh is not resident or its footprint is not known.
  const TextureFootprint* footprint(MeshKey key) const noexcept;
  bool contains(MeshKey key) const noexcept { return entries_.contains(key); }

  /// Starts a new round of use and evicts what does not fit the budget, but nothing in use or pinned.
  /// @param in_use    meshes that must stay until the next call.
  /// @param recently  meshes that were looked at: evicted after all that were not.
  void use(std::span<const MeshKey> in_use, std::span<const MeshKey> recently);

  /// Of meshes and footprints.
  uint64_t bytes() const noexcept { return bytes_; }
  /// Of some of them, each counted once; none for what is not resident.
  uint64_t bytesOf(std::span<const MeshKey> keys) const;
  uint64_t budgetBytes() const noexcept { return budget_bytes_; }
  size_t size() const noexcept { return entries_.size(); }

 private:
  struct KeyHash {
    size_t operator()(const MeshKey& key) const noexcept {
      return static_cast<size_t>((key.node.value * 64 + key.rung) * 0x9e3779b97f4a7c15ull >> 7);
    }
  };
  struct Entry {
    std::shared_ptr<const Mesh> mesh;
    std::shared_ptr<const TextureFootprint> footprint;
    uint64_t used_round = 0;
    uint64_t in_use_round = 0;
    bool pinned = false;
  };
  static uint64_t bytesOf(const Entry& entry) noexcept;
  void evict(MeshKey key);

  uint64_t budget_bytes_;
  uint64_t bytes_ = 0;
  uint64_t round_ = 1;
  std::unordered_map<MeshKey, Entry, KeyHash> entries_;
};

}  // namespace lode::core
