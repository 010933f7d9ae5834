#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "client/core/lod/cut.h"
#include "client/core/lod/request.h"
#include "client/core/textures/texture_cache.h"
#include "client/core/textures/texture_wants.h"
#include "client/core/textures/tile.h"
#include "common/codec/blob.h"
#include "common/codec/texture_set.h"

namespace lode::core {

/// Textures may use 1/4 of the memory budget of a textured model.
constexpr uint64_t kTextureBudgetShare = 4;

/// The textures of one model. Keeps the texture set and the resident tiles, and selects the tiles that the
/// view needs within the budget. Not thread safe.
class TextureStream {
 public:
  /// @param set_blob  blob of the encoded texture set.
  TextureStream(const BlobRef& set_blob, uint64_t budget_bytes);

  /// Decodes the texture set. @throws Error kFormat or kLimit.
  void takeSet(std::span<const std::byte> bytes);
  /// Returns the texture set; null until it is loaded.
  const std::shared_ptr<const TextureSet>& set() const noexcept { return set_; }

  /// Returns the size that the image of a tile must have. @param blob  blob number of a requested tile.
  glm::uvec2 imageSize(uint32_t blob) const { return keys_.find(blob)->second.image_size; }
  /// Returns true if the tile is the whole coarsest level of a texture, so that it needs a tail: see
  /// makeTail().
  bool isCoarsest(uint32_t blob) const { return keys_.find(blob)->second.coarsest; }
  void insert(uint32_t blob, std::shared_ptr<const TileImage> image) {
    cache_.insert(blob, std::move(image));
  }

  /// Notes that the blob of the set or of a tile cannot be loaded, and removes its request.
  void lose(uint32_t blob);

  /// Sets the budget, which takes effect at the next refine().
  void setBudget(uint64_t bytes) noexcept { cache_.setBudget(bytes); }

  /// Selects the tiles that the parts need, and evicts other tiles if memory is short. Does nothing until the
  /// set is loaded.
  void refine(std::span<const TexturedPart> parts, const View& view, float threshold_px);
  /// Returns the requests for needed tiles that are not resident, each blob once, best first. Until the
  /// texture set is loaded, returns the request for the set.
  const std::vector<Request>& missing() const noexcept { return missing_; }
  /// Returns true if every needed tile within the budget is resident or lost.
  bool complete() const noexcept {
    return (set_ ? refined_ : lost_.contains(set_blob_.number)) && missing_.empty();
  }
  /// Returns the number of needed tiles that exceed the budget.
  size_t leftOut() const noexcept { return left_out_; }

  /// Returns the number of visible tiles within the budget that are lost; 1 if the set is lost.
  size_t lostCount() const noexcept { return lost_.contains(set_blob_.number) ? 1 : lost_in_view_; }

  /// Returns all resident tiles, coarse levels first.
  std::vector<ResidentTile> residentTiles() const;
  uint64_t residentBytes() const noexcept { return cache_.bytes(); }
  size_t residentCount() const noexcept { return cache_.size(); }
  /// Returns the encoded size of the set and of the needed resident tiles.
  uint64_t blobBytesInUse() const noexcept { return blob_bytes_in_use_; }

 private:
  struct Keys {  // tiles that share one blob
    BlobRef blob;
    glm::uvec2 image_size{0};
    std::vector<TileKey> keys;
    bool coarsest = false;  // true if one of the tiles is the whole coarsest level of its texture
  };

  BlobRef set_blob_;
  TextureCache cache_;
  std::shared_ptr<const TextureSet> set_;
  std::map<uint32_t, Keys> keys_;  // tiles of the texture set, by blob number
  std::set<uint32_t> lost_;        // blob numbers of the tiles, or of the set, that cannot be loaded
  std::vector<Request> missing_;
  size_t left_out_ = 0, lost_in_view_ = 0;
  uint64_t blob_bytes_in_use_ = 0;
  bool refined_ = false;
};

}  // namespace lode::core
