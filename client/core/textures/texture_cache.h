#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "common/image/tile_image.h"

namespace lode::core {

/// The decoded tiles that are resident, by the number of their blob (several tiles may be one blob), within
/// a budget. What is in use stays; of the rest the least recently used goes first, of equals the higher
/// number. Not thread safe.
class TextureCache {
 public:
  explicit TextureCache(uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// A tile that is there already is kept as it is.
  void insert(uint32_t blob, std::shared_ptr<const TileImage> image);
  /// @return null if it is not resident.
  std::shared_ptr<const TileImage> find(uint32_t blob) const noexcept;

  /// Starts a new round of use and evicts what does not fit the budget, but nothing in use.
  /// @param in_use  blobs that must stay until the next call.
  void use(std::span<const uint32_t> in_use);

  /// Calls `visit(blob, image)` for every resident tile, by blob number.
  template <typename Visit>
  void forEach(Visit&& visit) const {
    for (const auto& [blob, entry] : entries_) visit(blob, entry.image);
  }

  uint64_t bytes() const noexcept { return bytes_; }  ///< room taken, see tileRoomBytes()
  uint64_t budgetBytes() const noexcept { return budget_bytes_; }
  /// From the next use() on.
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
