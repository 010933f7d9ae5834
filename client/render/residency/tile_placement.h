#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "client/core/lod/cut.h"
#include "client/core/textures/tile.h"
#include "client/render/residency/tile_cells.h"
#include "common/codec/texture_set.h"

namespace lode::render {

/// Places the texture tiles of a cut in the layers of a texture array, and keeps the table in which the mesh
/// shader finds the cell of a (texture, level, tile). The owner copies the images to their cells and the
/// table to the GPU. Unlike a mesh, a tile is used as soon as it is placed, and a coarser tile stands in for
/// a missing tile. Images are identified by their shared_ptr, but the placement does not keep them alive.
/// Uses no OpenGL. Not thread safe.
class TilePlacement {
 public:
  /// @param most_layers  largest number of layers of the array.
  explicit TilePlacement(uint32_t most_layers) : cells_(most_layers), most_layers_(most_layers) {}

  /// Changes the largest number of layers. A limit below the layers of the owner's array requires clear().
  void allow(uint32_t most_layers);
  /// Evicts all tiles and drops the texture set.
  void clear();

  /// Selects the tiles to place and to keep.
  /// @param newest  cut whose tiles are placed.
  /// @param drawn   cut that is drawn until the meshes of `newest` are resident, or null. If the tiles of
  /// both cuts fit, the tiles of `drawn` stay as long as it is drawn. If the two cuts have different texture
  /// sets, the tiles of `newest` wait as long.
  void show(const std::shared_ptr<const core::Cut>& newest, const std::shared_ptr<const core::Cut>& drawn);

  /// Returns the next tile to place, coarse levels first; null if all tiles are placed or do not fit.
  const core::ResidentTile* next() const noexcept { return waiting_.empty() ? nullptr : &waiting_.back(); }
  /// Places the next tile. Requires next().
  /// @return the cell of the image and those of its coarser levels, which the owner must fill; nothing if the
  /// image is already placed or does not fit. Valid until the next call.
  std::span<const TileCell> place();
  /// Changes the largest number of layers, evicts all images and queues the tiles of the cut, the largest
  /// first. This order leaves no gaps between cells.
  void repack(uint32_t most_layers);

  const std::shared_ptr<const TextureSet>& set() const noexcept { return set_; }
  size_t tileCount() const noexcept { return entries_.size(); }
  /// Returns true if a placed image of the set has transparent texels.
  bool hasClear() const noexcept { return has_clear_; }
  /// Returns the number of layers that the array needs.
  uint32_t layers() const noexcept { return cells_.layers(); }

  /// Returns the table; empty without a texture set. The table begins with a header per texture: width,
  /// height, number of levels including the tail (client/core/textures/tile.h), and index of the level list.
  /// The level lists and entries of all textures follow. A level list has the index of each level's first
  /// entry. Each tile and each tail level has an entry: layer and corner of its cell, or 0.
  const std::vector<uint32_t>& table() const noexcept { return table_; }
  /// Returns the indices of the words of the table that have changed since the last call.
  std::vector<size_t> takeChangedWords() { return std::exchange(changed_words_, {}); }
  /// Returns a number that changes when the table has another size, for another texture set.
  uint64_t tableSerial() const noexcept { return table_serial_; }

 private:
  using Image = std::shared_ptr<const TileImage>;
  struct Entry {
    std::vector<TileCell> cells;      ///< cell of the image, then cells of its coarser levels
    std::vector<core::TileKey> keys;  ///< tiles that share this image
  };
  using Entries = std::map<std::weak_ptr<const TileImage>, Entry, std::owner_less<>>;

  void takeSet(std::shared_ptr<const TextureSet> set);
  void evictUnused();
  void setPages(const core::TileKey& key, std::span<const TileCell> cells);
  std::vector<TileCell> allocate(const TileImage& image);
  void release(std::span<const TileCell> cells);

  TileCells cells_;
  uint32_t most_layers_;
  std::shared_ptr<const TextureSet> set_;
  std::vector<uint32_t> table_;
  std::vector<size_t> changed_words_;
  uint64_t table_serial_ = 0;
  bool has_clear_ = false;
  std::vector<size_t> first_entries_;  ///< table index of each texture's first tile
  Entries entries_;
  std::shared_ptr<const core::Cut> cut_;     ///< cut whose tiles to place
  std::shared_ptr<const core::Cut> drawn_;   ///< cut whose tiles stay
  std::vector<core::ResidentTile> waiting_;  ///< tiles to place; the next tile is the last element
  bool repacked_ = false;                    ///< true if repack() was called for this cut
};

}  // namespace lode::render
