#include "client/core/cache/mesh_cache.h"

#include <algorithm>
#include <utility>

namespace lode::core {

uint64_t meshBytes(uint64_t vertices, uint64_t triangles, AttributeSet attributes) noexcept {
  const uint64_t attribute_bytes = attributes.bits != 0 ? sizeof(VertexAttributes) : 0;
  return sizeof(Mesh) + vertices * (sizeof(PositionCode) + attribute_bytes) +
         triangles * sizeof(glm::u32vec3) + clusterCount(triangles) * sizeof(LatticeBox);
}

uint64_t meshBytes(const Mesh& mesh) noexcept {
  return sizeof(Mesh) + mesh.positions.size() * sizeof(PositionCode) +
         mesh.vertex_attributes.size() * sizeof(VertexAttributes) +
         mesh.triangles.size() * sizeof(glm::u32vec3) + mesh.cluster_boxes.size() * sizeof(LatticeBox);
}

const MeshCache::Entry* MeshCache::Lods::find(uint32_t lod) const noexcept {
  for (const Entry& entry : entries_)
    if (entry.lod == lod) return &entry;
  return nullptr;
}

std::shared_ptr<const Mesh> MeshCache::Lods::mesh(uint32_t lod) const noexcept {
  const Entry* entry = find(lod);
  return entry == nullptr ? nullptr : entry->mesh;
}

const MeshCache::Lods& MeshCache::lodsOf(NodeKey node) const noexcept {
  static const Lods none;
  const auto found = nodes_.find(node.value);
  return found == nodes_.end() ? none : found->second;
}

MeshCache::Entry* MeshCache::entryOf(MeshKey key) noexcept {
  const auto found = nodes_.find(key.node.value);
  return found == nodes_.end() ? nullptr : const_cast<Entry*>(found->second.find(key.lod));
}

void MeshCache::insert(MeshKey key, std::shared_ptr<const Mesh> mesh,
                       std::shared_ptr<const TextureFootprint> footprint) {
  Lods& lods = nodes_[key.node.value];
  if (lods.has(key.lod)) return;
  lods.resident_ |= uint64_t{1} << key.lod;
  lods.entries_.push_back({key.lod, false, std::move(mesh), std::move(footprint), round_, round_});
  bytes_ += bytesOf(lods.entries_.back());
  ++size_;
}

uint64_t MeshCache::bytesOf(const Entry& entry) noexcept {
  return meshBytes(*entry.mesh) + (entry.footprint ? footprintBytes(*entry.footprint) : 0);
}

void MeshCache::pin(MeshKey key) {
  if (Entry* entry = entryOf(key)) entry->pinned = true;
}

void MeshCache::setFootprint(MeshKey key, std::shared_ptr<const TextureFootprint> footprint) {
  Entry* entry = entryOf(key);
  if (entry == nullptr) return;
  bytes_ -= bytesOf(*entry);
  entry->footprint = std::move(footprint);
  bytes_ += bytesOf(*entry);
}

const TextureFootprint* MeshCache::footprint(MeshKey key) const noexcept {
  const Entry* entry = lodsOf(key.node).find(key.lod);
  return entry == nullptr ? nullptr : entry->footprint.get();
}

uint64_t MeshCache::use(std::span<const MeshKey> in_use, std::span<const MeshKey> recently) {
  ++round_;
  for (const MeshKey& key : recently)
    if (Entry* entry = entryOf(key)) entry->used_round = round_;
  uint64_t bytes = 0;
  for (const MeshKey& key : in_use) {
    Entry* entry = entryOf(key);
    if (entry == nullptr || entry->in_use_round == round_) continue;
    entry->used_round = entry->in_use_round = round_;
    bytes += bytesOf(*entry);
  }
  return bytes;
}

void MeshCache::trim() {
  if (bytes_ <= budget_bytes_) return;
  struct Spare {
    uint64_t used_round = 0;
    MeshKey key;
  };
  std::vector<Spare> spare;
  for (const auto& [node, lods] : nodes_)
    for (const Entry& entry : lods.entries_)
      if (!entry.pinned && entry.in_use_round != round_)
        spare.push_back({entry.used_round, {NodeKey{node}, entry.lod}});
  std::sort(spare.begin(), spare.end(), [](const Spare& a, const Spare& b) {
    // Among meshes last used in the same round, evict deeper nodes first.
    return a.used_round != b.used_round ? a.used_round < b.used_round : b.key < a.key;
  });
  for (const Spare& next : spare) {
    if (bytes_ <= budget_bytes_) break;
    evict(next.key);
  }
}

void MeshCache::evict(MeshKey key) {
  const auto node = nodes_.find(key.node.value);
  Lods& lods = node->second;
  const Entry* entry = lods.find(key.lod);
  bytes_ -= bytesOf(*entry);
  --size_;
  lods.resident_ &= ~(uint64_t{1} << key.lod);
  lods.entries_.erase(lods.entries_.begin() + (entry - lods.entries_.data()));
  if (lods.entries_.empty()) nodes_.erase(node);
}

}  // namespace lode::core
