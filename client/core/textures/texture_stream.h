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

/// One in so many bytes of a client's memory budget is for the textures of a model that has any.
constexpr uint64_t kTextureBudgetShare = 4;

/// The textures of one model as they stream in: the set, the tiles that the view needs within the budget, and
/// those that are resident. Not thread safe.
class TextureStream {
 public:
  /// @param set_blob  of the encoded set.
  TextureStream(const BlobRef& set_blob, uint64_t budget_bytes);

  /// @throws Error kFormat or kLimit.
  void takeSet(std::span<const std::byte> bytes);
  /// Null until it is there.
  const std::shared_ptr<const TextureSet>& set() const noexcept { return set_; }

  /// Size that the image of a blob must have. @param blob  of a tile that was wanted.
  glm::uvec2 imageSize(uint32_t blob) const { return keys_.find(blob)->second.image_size; }
  /// It is all of a texture's coarsest level, and is to have a tail.
  bool isCoarsest(uint32_t blob) const { return keys_.find(blob)->second.coarsest; }
  void insert(uint32_t blob, std::shared_ptr<const TileImage> image) {
    cache_.insert(blob, std::move(image));
  }

  /// A blob cannot be had, the set's or a tile's: from the next refine() on it is not needed.
  void lose(uint32_t blob);

  /// From the next refine() on.
  void setBudget(uint64_t bytes) noexcept { cache_.setBudget(bytes); }

  /// Decides what is needed, and evicts what is not where room is short. Does nothing without the set.
  void refine(std::span<const TexturedPart> parts, const View& view, float threshold_px);
  /// Needed and not resident, each blob once, best first; the set alone until it is there.
  const std::vector<Request>& missing() const noexcept { return missing_; }
  /// All is there that can be had, that the view needs and that the budget allows.
  bool complete() const noexcept {
    return (set_ ? refined_ : lost_.contains(set_blob_.number)) && missing_.empty();
  }
  /// Tiles that the view needs and the budget does not allow.
  size_t leftOut() const noexcept { return left_out_; }

  /// Of those within it, the tiles that the view sees and that cannot be had; 1 where the set cannot.
  size_t lostCount() const noexcept { return lost_.contains(set_blob_.number) ? 1 : lost_in_view_; }

  /// All resident tiles, coarse levels first.
  std::vector<ResidentTile> residentTiles() const;
  uint64_t residentBytes() const noexcept { return cache_.bytes(); }
  size_t residentCount() const noexcept { return cache_.size(); }
  /// Of the set, and of the tiles that are both needed and resident.
  uint64_t blobBytesInUse() const noexcept { return blob_bytes_in_use_; }

 private:
  struct Keys {  // of the tiles that are one blob
    BlobRef blob;
    glm::uvec2 image_size{0};
    std::vector<TileKey> keys;
    bool coarsest = false;  // one of them is all of its texture's coarsest level
  };

  BlobRef set_blob_;
  TextureCache cache_;
  std::shared_ptr<const TextureSet> set_;
  std::map<uint32_t, Keys> keys_;  // by blob number
  std::set<uint32_t> lost_;        // blob numbers
  std::vector<Request> missing_;
  size_t left_out_ = 0, lost_in_view_ = 0;
  uint64_t blob_bytes_in_use_ = 0;
  bool refined_ = false;
};

}  // namespace lode::core
