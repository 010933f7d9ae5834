#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "client/core/lod/cut.h"
#include "client/core/textures/tile.h"
#include "client/render/gl_names.h"
#include "client/render/residency/mesh_residency.h"
#include "client/render/residency/staging_ring.h"
#include "client/render/residency/tile_cells.h"

namespace lode::render {

constexpr uint32_t kTileLayerBytes = kTilePx * kTilePx * 4;              ///< of one layer of the array
constexpr uint32_t kLeastTextureStagingBytes = kTileLayerBytes * 3 / 2;  ///< a tile and its tail fit

/// Which tiles are on the GPU: one texture array of a bounded number of layers, in which small tiles share
/// a layer, and a table from (texture, level, tile) to their places that the mesh shader walks. Unlike
/// meshes, tiles are shown as they come: a coarser one stands in for a finer one. Images are known by their
/// shared_ptr's identity and not kept alive. Used on the thread of its context.
class TextureResidency {
 public:
  /// @param budget_bytes  of the array; at least one layer is used all the same.
  /// @param staging_bytes  most that one frame uploads.
  explicit TextureResidency(uint64_t budget_bytes, uint32_t staging_bytes = 4 * kTileLayerBytes);

  /// Another from now on: what is there goes, and comes again when a cut is shown next.
  void setBudget(uint64_t bytes);

  /// @param newest  the cut whose tiles are wanted.
  /// @param drawn   the one that is drawn until the newest one's meshes are there, or null: its tiles stay
  /// until
  ///                then, where there is room for both; and one of another texture set keeps the newest
  ///                waiting.
  void show(const std::shared_ptr<const core::Cut>& newest,
            const std::shared_ptr<const core::Cut>& drawn = nullptr);
  /// Uploads tiles, coarse levels first, within the budget: at least one. @return bytes uploaded.
  uint64_t uploadInRenderThread(const UploadBudget& budget);

  /// All tiles of the cut are there, but those for which there is no room.
  bool upToDate() const noexcept { return waiting_.empty(); }
  size_t tileCount() const noexcept { return entries_.size(); }
  uint64_t bytes() const noexcept { return uint64_t{array_layers_} * kTileLayerBytes; }
  /// That uploads go through.
  uint64_t stagingBytes() const noexcept {
    return staging_ ? uint64_t{StagingRing::kSegments} * staging_bytes_ : 0;
  }

  /// Null while nothing textured is to be drawn.
  const TextureSet* set() const noexcept { return set_.get(); }
  /// An image of the set was uploaded that is not opaque everywhere.
  bool hasClear() const noexcept { return has_clear_; }
  /// Binds array and table to texture unit and storage buffer 0.
  void bind() const;

 private:
  using Image = std::shared_ptr<const TileImage>;
  struct Entry {
    std::vector<TileCell> cells;      ///< of the image, then of its tail
    std::vector<core::TileKey> keys;  ///< of the tiles that are this image
  };
  using Entries = std::map<std::weak_ptr<const TileImage>, Entry, std::owner_less<>>;

  void takeSet(std::shared_ptr<const TextureSet> set);
  void giveUpOthers();
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
  std::vector<uint32_t> first_entries_;  ///< in the table, by texture; its tail's come after its tiles'
  Entries entries_;
  std::shared_ptr<const core::Cut> cut_;     ///< the one whose tiles are wanted
  std::shared_ptr<const core::Cut> drawn_;   ///< the one whose tiles stay
  std::vector<core::ResidentTile> waiting_;  ///< to be uploaded, the next one last
  bool repacked_ = false;                    ///< for this cut
};

}  // namespace lode::render
