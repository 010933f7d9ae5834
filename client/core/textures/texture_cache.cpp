#include "client/core/textures/texture_cache.h"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "client/core/textures/texture_wants.h"

namespace lode::core {

void TextureCache::insert(uint32_t blob, std::shared_ptr<const TileImage> image) {
  const uint64_t room_bytes = tileRoomBytes(*image);
  if (entries_.try_emplace(blob, Entry{std::move(image), round_}).second) bytes_ += room_bytes;
}

std::shared_ptr<const TileImage> TextureCache::find(uint32_t blob) const noexcept {
  const auto entry = entries_.find(blob);
  return entry == entries_.end() ? nullptr : entry->second.image;
}

void TextureCache::use(std::span<const uint32_t> in_use) {
  ++round_;
  for (const uint32_t blob : in_use)
    if (const auto entry = entries_.find(blob); entry != entries_.end()) entry->second.used_round = round_;
  if (bytes_ <= budget_bytes_) return;

  std::vector<std::pair<uint64_t, uint32_t>> candidates;  // pairs of last used round and blob number
  for (const auto& [blob, entry] : entries_)
    if (entry.used_round != round_) candidates.emplace_back(entry.used_round, blob);
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second > b.second;
  });
  for (const auto& [round, blob] : candidates) {
    if (bytes_ <= budget_bytes_) break;
    const auto entry = entries_.find(blob);
    bytes_ -= tileRoomBytes(*entry->second.image);
    entries_.erase(entry);
  }
}

}  // namespace lode::core
