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
  glm::uvec2 corner{0};  ///< in texels, a multiple of the edge
  uint32_t edge = 0;     ///< in texels, a power of two from kLeastTileCellPx to kTilePx
};

/// Allocates squares of layers of kTilePx × kTilePx texels. Each layer is a quadtree whose free squares split
/// and coalesce by four (buddy allocation; Knowlton, A Fast Storage Allocator, 1965). Takes the smallest free
/// square that fits, in the lowest layer. Pure bookkeeping, not thread safe.
class TileCells {
 public:
  /// @param most_layers  limit of layers in use.
  explicit TileCells(uint32_t most_layers) : most_layers_(most_layers) {}

  /// @param size  size of an image, at most kTilePx per side. @return nothing if there is no room.
  std::optional<TileCell> allocate(glm::uvec2 size);
  /// @param cell  as returned by allocate().
  void release(const TileCell& cell);
  /// Raises the limit of layers.
  void allow(uint32_t most_layers) noexcept { most_layers_ = most_layers; }
  /// Peak number of layers in use.
  uint32_t layers() const noexcept { return layers_; }

 private:
  static constexpr uint32_t kOrders = 5;  // edges of 512, 256, 128, 64 and 32 texels
  static constexpr uint32_t edgeOf(uint32_t order) noexcept { return kTilePx >> order; }
  using Place = std::tuple<uint32_t, uint32_t, uint32_t>;  // layer, y, x

  std::array<std::set<Place>, kOrders> free_;
  uint32_t layers_ = 0, most_layers_;
};

constexpr uint32_t kTileLayerBytes = kTilePx * kTilePx * 4;              ///< size of a layer of the array
constexpr uint32_t kLeastTextureStagingBytes = kTileLayerBytes * 3 / 2;  ///< room for a tile and its tail

/// Keeps texture tiles on the GPU: a texture array of a bounded number of layers, in which small tiles share
/// a layer, and a table from (texture, level, tile) to cells that the mesh shader reads. Unlike meshes, a
/// tile is used as soon as it is resident; a coarser one stands in for a missing one. Images are identified
/// by their shared_ptr and not kept alive. Use it on the thread of its context.
class TextureResidency {
 public:
  /// @param budget_bytes   size limit of the array, but at least one layer.
  /// @param staging_bytes  limit of uploads per frame.
  explicit TextureResidency(uint64_t budget_bytes, uint32_t staging_bytes = 4 * kTileLayerBytes);

  /// Changes the budget. A smaller array than the current one evicts all tiles; the next show() uploads them
  /// again.
  void setBudget(uint64_t bytes);

  /// @param newest  cut whose tiles to upload.
  /// @param drawn   cut drawn until the meshes of the newest are resident, or null. Its tiles stay until then
  /// if
  ///                both fit. If its texture set differs, the tiles of the newest wait.
  void show(const std::shared_ptr<const core::Cut>& newest,
            const std::shared_ptr<const core::Cut>& drawn = nullptr);
  /// Uploads tiles, coarse levels first: at least one, then more within the budget. @return bytes uploaded.
  uint64_t uploadInRenderThread(const UploadBudget& budget);

  /// True if all tiles of the cut are resident, except those for which there is no room.
  bool upToDate() const noexcept { return waiting_.empty(); }
  size_t tileCount() const noexcept { return entries_.size(); }
  uint64_t bytes() const noexcept { return uint64_t{array_layers_} * kTileLayerBytes; }
  /// Size of the staging ring.
  uint64_t stagingBytes() const noexcept {
    return staging_ ? uint64_t{StagingRing::kSegments} * staging_bytes_ : 0;
  }

  /// The texture set in use; null if the cut has no textures.
  const TextureSet* set() const noexcept { return set_.get(); }
  /// True if an image of the set that was uploaded has transparent texels.
  bool hasClear() const noexcept { return has_clear_; }
  /// Binds array and table to texture unit and storage buffer 0.
  void bind() const;

 private:
  using Image = std::shared_ptr<const TileImage>;
  struct Entry {
    std::vector<TileCell> cells;      ///< cell of the image, then cells of its tail
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
  std::vector<uint32_t> first_entries_;  ///< by texture: table index of its first tile; tail levels follow
  Entries entries_;
  std::shared_ptr<const core::Cut> cut_;     ///< cut whose tiles to upload
  std::shared_ptr<const core::Cut> drawn_;   ///< cut whose tiles stay
  std::vector<core::ResidentTile> waiting_;  ///< tiles to upload, the next one last
  bool repacked_ = false;                    ///< whether repack() ran for this cut
};

}  // namespace lode::render
