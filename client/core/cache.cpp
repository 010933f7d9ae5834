#include "client/core/cache.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace lode::core {

uint64_t meshBytes(uint64_t vertices, uint64_t triangles, AttributeSet attributes) noexcept {
  const uint64_t attribute_bytes = attributes.bits != 0 ? sizeof(VertexAttributes) : 0;
  return sizeof(Mesh) + vertices * (sizeof(PositionCode) + attribute_bytes) +
         triangles * sizeof(glm::u32vec3);
}

uint64_t meshBytes(const Mesh& mesh) noexcept {
  return sizeof(Mesh) + mesh.positions.size() * sizeof(PositionCode) +
         mesh.vertex_attributes.size() * sizeof(VertexAttributes) +
         mesh.triangles.size() * sizeof(glm::u32vec3);
}

void MeshCache::insert(MeshKey key, std::shared_ptr<const Mesh> mesh,
                       std::shared_ptr<const TextureFootprint> footprint) {
  const auto [entry, is_new] =
      entries_.try_emplace(key, Entry{std::move(mesh), std::move(footprint), round_, round_, false});
  if (is_new) bytes_ += bytesOf(entry->second);
}

uint64_t MeshCache::bytesOf(const Entry& entry) noexcept {
  return meshBytes(*entry.mesh) + (entry.footprint ? footprintBytes(*entry.footprint) : 0);
}

uint64_t MeshCache::bytesOf(std::span<const MeshKey> keys) const {
  std::vector<MeshKey> each(keys.begin(), keys.end());
  std::sort(each.begin(), each.end());
  each.erase(std::unique(each.begin(), each.end()), each.end());
  uint64_t bytes = 0;
  for (const MeshKey& key : each)
    if (const auto entry = entries_.find(key); entry != entries_.end()) bytes += bytesOf(entry->second);
  return bytes;
}

void MeshCache::pin(MeshKey key) {
  if (const auto entry = entries_.find(key); entry != entries_.end()) entry->second.pinned = true;
}

std::shared_ptr<const Mesh> MeshCache::find(MeshKey key) const noexcept {
  const auto entry = entries_.find(key);
  return entry == entries_.end() ? nullptr : entry->second.mesh;
}

void MeshCache::setFootprint(MeshKey key, std::shared_ptr<const TextureFootprint> footprint) {
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) return;
  bytes_ -= bytesOf(entry->second);
  entry->second.footprint = std::move(footprint);
  bytes_ += bytesOf(entry->second);
}

const TextureFootprint* MeshCache::footprint(MeshKey key) const noexcept {
  const auto entry = entries_.find(key);
  return entry == entries_.end() ? nullptr : entry->second.footprint.get();
}

void MeshCache::use(std::span<const MeshKey> in_use, std::span<const MeshKey> recently) {
  ++round_;
  for (const MeshKey& key : recently)
    if (const auto entry = entries_.find(key); entry != entries_.end()) entry->second.used_round = round_;
  for (const MeshKey& key : in_use) {
    if (const auto entry = entries_.find(key); entry != entries_.end())
      entry->second.used_round = entry->second.in_use_round = round_;
  }
  if (bytes_ <= budget_bytes_) return;

  std::vector<MeshKey> candidates;
  for (const auto& [key, entry] : entries_)
    if (!entry.pinned && entry.in_use_round != round_) candidates.push_back(key);
  std::sort(candidates.begin(), candidates.end(), [&](const MeshKey& a, const MeshKey& b) {
    const uint64_t a_used = entries_.at(a).used_round, b_used = entries_.at(b).used_round;
    return std::tie(a_used, b) < std::tie(b_used, a);  // the older first, then the deeper
  });
  for (const MeshKey& key : candidates) {
    if (bytes_ <= budget_bytes_) break;
    evict(key);
  }
}

void MeshCache::evict(MeshKey key) {
  const auto entry = entries_.find(key);
  bytes_ -= bytesOf(entry->second);
  entries_.erase(entry);
}

}  // namespace lode::core
