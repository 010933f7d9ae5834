#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "client/core/lod/cut.h"
#include "client/render/gl/gl_names.h"
#include "client/render/residency/mesh_residency.h"
#include "client/render/residency/staging_ring.h"
#include "client/render/residency/tile_placement.h"
#include "common/codec/texture_set.h"

namespace lode::render {

constexpr uint32_t kTileLayerBytes = kTilePx * kTilePx * 4;  ///< size of a layer of the array
/// Smallest upload limit per frame: room for a tile and its tail, the coarser mip levels that the client
/// computes (see client/core/textures/tile.h).
constexpr uint32_t kLeastTextureStagingBytes = kTileLayerBytes * 3 / 2;

/// Keeps texture tiles on the GPU, in a texture array of a bounded number of layers, where TilePlacement
/// places them. Use the object on the thread of its OpenGL context.
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

  /// Selects the tiles to upload and to keep: see TilePlacement::show().
  void show(const std::shared_ptr<const core::Cut>& newest,
            const std::shared_ptr<const core::Cut>& drawn = nullptr);
  /// Uploads tiles, coarse levels first. Uploads at least one tile, and more if the budget allows. @return
  /// bytes uploaded.
  uint64_t uploadInRenderThread(const UploadBudget& budget);

  /// Returns true if all tiles of the cut are resident, except tiles that do not fit.
  bool upToDate() const noexcept { return placement_.next() == nullptr; }
  size_t tileCount() const noexcept { return placement_.tileCount(); }
  uint64_t bytes() const noexcept { return uint64_t{array_layers_} * kTileLayerBytes; }
  /// Returns the size of the staging ring.
  uint64_t stagingBytes() const noexcept {
    return staging_ ? uint64_t{StagingRing::kSegments} * staging_bytes_ : 0;
  }

  /// Returns the texture set in use, or null if the cut has no textures.
  const TextureSet* set() const noexcept { return placement_.set().get(); }
  /// Returns true if an uploaded image of the set has transparent texels.
  bool hasClear() const noexcept { return placement_.hasClear(); }
  /// Binds the array to texture unit 0 and the table to storage buffer 0.
  void bind() const;

 private:
  void writeTable();
  void copy(const TileImage& image, const TileCell& cell);
  bool uploadNext();
  bool growTo(uint32_t layers);

  TilePlacement placement_;
  uint32_t most_layers_, array_layers_ = 0, staging_bytes_;
  std::optional<StagingRing> staging_;
  GlTextureArray array_;
  GlBuffer table_;
  uint64_t table_serial_ = 0;  ///< TilePlacement::tableSerial() of table_
};

}  // namespace lode::render
