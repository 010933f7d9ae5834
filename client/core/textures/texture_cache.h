#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "common/image/tile_image.h"

namespace lode::core {

/// The resident decoded tiles by blob number, within a budget. Equal tiles share a blob. Keeps tiles in use;
/// evicts the rest least recently used first, then higher numbers first. Not thread safe.
class TextureCache {
 public:
  explicit TextureCache(uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// Adds a tile; keeps the old one if it is resident already.
  void insert(uint32_t blob, std::shared_ptr<const TileImage> image);
  /// @return null if it is not resident.
  std::shared_ptr<const TileImage> find(uint32_t blob) const noexcept;

  /// Starts a new round of use and evicts tiles until the rest fits the budget, but none in use.
  /// @param in_use  blobs that must stay until the next call.
  void use(std::span<const uint32_t> in_use);

  /// Calls `visit(blob, image)` for every resident tile, by blob number.
  template <typename Visit>
  void forEach(Visit&& visit) const {
    for (const auto& [blob, entry] : entries_) visit(blob, entry.image);
  }

  uint64_t bytes() const noexcept { return bytes_; }  ///< sum of tileRoomBytes()
  uint64_t budgetBytes() const noexcept { return budget_bytes_; }
  /// Takes effect at the next use().
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
