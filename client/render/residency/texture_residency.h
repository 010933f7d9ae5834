#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <tuple>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/lod/cut.h"
#include "client/core/textures/tile.h"
#include "client/render/gl/gl_names.h"
#include "client/render/residency/mesh_residency.h"
#include "client/render/residency/staging_ring.h"
#include "common/codec/texture_set.h"

namespace lode::render {

/// A square in a layer of the texture array.
struct TileCell {
  uint32_t layer = 0;
  glm::uvec2 corner{0};  ///< top left corner in texels, a multiple of the edge
  uint32_t edge = 0;     ///< edge in texels, a power of two from kLeastTileCellPx to kTilePx
};

/// Allocates squares in layers of kTilePx × kTilePx texels. Each layer is a quadtree: a free square splits
/// into four, and four free squares join again (buddy allocation; Knowlton, A Fast Storage Allocator, 1965).
/// Allocates the smallest free square that fits; among equal squares, the one in the layer with the smallest
/// index. Uses no OpenGL. Not thread safe.
class TileCells {
 public:
  /// @param most_layers  largest number of layers to use.
  explicit TileCells(uint32_t most_layers) : most_layers_(most_layers) {}

  /// @param size  size of an image, at most kTilePx per side. @return nothing if there is no room.
  std::optional<TileCell> allocate(glm::uvec2 size);
  /// @param cell  cell that allocate() returned.
  void release(const TileCell& cell);
  /// Changes the limit of the number of layers.
  void allow(uint32_t most_layers) noexcept { most_layers_ = most_layers; }
  /// Returns the peak number of layers in use.
  uint32_t layers() const noexcept { return layers_; }

 private:
  static constexpr uint32_t kOrders = 5;  // number of square sizes: 512, 256, 128, 64 and 32 texels
  static constexpr uint32_t edgeOf(uint32_t order) noexcept { return kTilePx >> order; }
  using Place = std::tuple<uint32_t, uint32_t, uint32_t>;  // layer, y, x

  std::array<std::set<Place>, kOrders> free_;
  uint32_t layers_ = 0, most_layers_;
};

constexpr uint32_t kTileLayerBytes = kTilePx * kTilePx * 4;  ///< size of a layer of the array
/// Smallest upload limit per frame: room for a tile and its tail, the coarser mip levels that the client
/// computes (see client/core/textures/tile.h).
constexpr uint32_t kLeastTextureStagingBytes = kTileLayerBytes * 3 / 2;

/// Keeps texture tiles on the GPU. The tiles are in a texture array of a bounded number of layers; small
/// tiles share a layer. The mesh shader finds the cell of a (texture, level, tile) in a table. Unlike a mesh,
/// a tile is used as soon as it is resident, and a coarser tile stands in for a missing tile. Images are
/// identified by their shared_ptr, but the residency does not keep them alive. Use the object on the thread
/// of its OpenGL context.
class TextureResidency {
 public:
  /// @param budget_bytes   limit of the array's size. One layer is always allowed.
  /// @param staging_bytes  limit of uploads per frame.
  explicit TextureResidency(uint64_t budget_bytes, uint32_t staging_bytes = 4 * kTileLayerBytes);

  /// Changes the budget. If the current array exceeds the new budget, evicts all tiles; the tiles are
  /// uploaded again after the next show().
  void setBudget(uint64_t bytes);

  /// Evicts all tiles and frees the array. Draws no textures until the next show().
  void release();

  /// Selects the tiles to upload and to keep.
  /// @param newest  cut whose tiles are uploaded.
  /// @param drawn   cut that is drawn until the meshes of `newest` are resident, or null. If the tiles of
  /// both cuts fit, the tiles of `drawn` stay until then. If the two cuts have different texture sets, the
  /// tiles of `newest` wait until then.
  void show(const std::shared_ptr<const core::Cut>& newest,
            const std::shared_ptr<const core::Cut>& drawn = nullptr);
  /// Uploads tiles, coarse levels first. Uploads at least one tile, and more if the budget allows. @return
  /// bytes uploaded.
  uint64_t uploadInRenderThread(const UploadBudget& budget);

  /// Returns true if all tiles of the cut are resident, except tiles that do not fit.
  bool upToDate() const noexcept { return waiting_.empty(); }
  size_t tileCount() const noexcept { return entries_.size(); }
  uint64_t bytes() const noexcept { return uint64_t{array_layers_} * kTileLayerBytes; }
  /// Returns the size of the staging ring.
  uint64_t stagingBytes() const noexcept {
    return staging_ ? uint64_t{StagingRing::kSegments} * staging_bytes_ : 0;
  }

  /// Returns the texture set in use, or null if the cut has no textures.
  const TextureSet* set() const noexcept { return set_.get(); }
  /// Returns true if an uploaded image of the set has transparent texels.
  bool hasClear() const noexcept { return has_clear_; }
  /// Binds the array to texture unit 0 and the table to storage buffer 0.
  void bind() const;

 private:
  using Image = std::shared_ptr<const TileImage>;
  struct Entry {
    std::vector<TileCell> cells;      ///< cell of the image, then cells of its coarser levels
    std::vector<core::TileKey> keys;  ///< tiles that share this image
  };
  using Entries = std::map<std::weak_ptr<const TileImage>, Entry, std::owner_less<>>;

  void takeSet(std::shared_ptr<const TextureSet> set);
  void evictUnused();
  void repack();
  void setPages(const core::TileKey& key, std::span<const TileCell> cells);
  std::vector<TileCell> allocate(const TileImage& image);
  void release(std::span<const TileCell> cells);
  void copy(const TileImage& image, const TileCell& cell);
  bool upload(const core::ResidentTile& tile);
  bool growTo(uint32_t layers);

  TileCells cells_;
  uint32_t most_layers_, array_layers_ = 0, staging_bytes_;
  std::optional<StagingRing> staging_;
  GlTextureArray array_;
  GlBuffer table_;
  std::shared_ptr<const TextureSet> set_;
  bool has_clear_ = false;
  std::vector<uint32_t> first_entries_;  ///< table index of each texture's first tile
  Entries entries_;
  std::shared_ptr<const core::Cut> cut_;     ///< cut whose tiles to upload
  std::shared_ptr<const core::Cut> drawn_;   ///< cut whose tiles stay
  std::vector<core::ResidentTile> waiting_;  ///< tiles to upload; the next tile is the last element
  bool repacked_ = false;                    ///< true if repack() was called for this cut
};

}  // namespace lode::render
