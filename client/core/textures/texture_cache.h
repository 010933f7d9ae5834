#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "common/image/tile_image.h"

namespace lode::core {

/// Caches decoded tiles by blob number within a memory budget. Tiles with equal contents share a blob. Never
/// evicts tiles in use. Evicts the others least recently used first; among tiles last used in the same round,
/// larger blob numbers go first. Not thread safe.
class TextureCache {
 public:
  explicit TextureCache(uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// Adds a tile. Does nothing if the blob's image is already resident.
  void insert(uint32_t blob, std::shared_ptr<const TileImage> image);
  /// @return null if the tile is not resident.
  std::shared_ptr<const TileImage> find(uint32_t blob) const noexcept;

  /// Starts a new round of use and evicts tiles until the rest fits the budget. Never evicts tiles in use.
  /// @param in_use  blob numbers of tiles that must stay until the next call.
  void use(std::span<const uint32_t> in_use);

  /// Calls `visit(blob, image)` for every resident tile, in the order of blob numbers.
  template <typename Visit>
  void forEach(Visit&& visit) const {
    for (const auto& [blob, entry] : entries_) visit(blob, entry.image);
  }

  uint64_t bytes() const noexcept { return bytes_; }  ///< sum of tileRoomBytes() over all resident tiles
  uint64_t budgetBytes() const noexcept { return budget_bytes_; }
  /// Sets the budget; it takes effect at the next use().
  void setBudget(uint64_t bytes) noexcept { budget_bytes_ = bytes; }
  size_t size() const noexcept { return entries_.size(); }

 private:
  struct Entry {
    std::shared_ptr<const TileImage> image;
    uint64_t used_round = 0;
  };

  uint64_t budget_bytes_;
  uint64_t bytes_ = 0;
  uint64_t round_ = 1;
  std::map<uint32_t, Entry> entries_;
};

}  // namespace lode::core
