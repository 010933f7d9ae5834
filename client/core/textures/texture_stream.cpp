#include "client/core/textures/texture_stream.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "common/error.h"

namespace lode::core {
namespace {

/// Calls `use(key)` for every tile of a texture.
template <typename Use>
void forEachTile(const Texture& texture, uint32_t number, Use&& use) {
  for (uint32_t level = levelCount(texture); level-- > 0;)
    for (uint32_t y = 0; y < tilesDown(texture, level); ++y)
      for (uint32_t x = 0; x < tilesAcross(texture, level); ++x) use(TileKey{level, number, y, x});
}

}  // namespace

TextureStream::TextureStream(const BlobRef& set_blob, uint64_t budget_bytes)
    : set_blob_(set_blob), cache_(budget_bytes) {
  constexpr float kFirst = std::numeric_limits<float>::max();
  missing_.push_back({set_blob_, {BlobKind::kTextureSet, {}}, proto::RequestClass::kVisible, kFirst});
}

void TextureStream::takeSet(std::span<const std::byte> bytes) {
  auto set = std::make_shared<const TextureSet>(decodeTextureSet(bytes));
  std::map<uint32_t, Keys> keys;
  for (uint32_t number = 0; number < set->textures.size(); ++number) {
    forEachTile(set->textures[number], number, [&](const TileKey& key) {
      const BlobRef& blob = tileBlob(*set, key);
      const glm::uvec2 image_size = tileImageSize(*set, key);
      Keys& same = keys.try_emplace(blob.number, Keys{blob, image_size, {}, false}).first->second;
      if (same.blob != blob || same.image_size != image_size)
        throw Error(ErrorCode::kFormat, "damaged texture set: blob " + std::to_string(blob.number) +
                                            " is used for different tiles; rebuild the store");
      same.keys.push_back(key);
      same.coarsest |= key.level + 1 == levelCount(set->textures[number]);
    });
  }
  set_ = std::move(set);
  missing_.clear();
  keys_ = std::move(keys);
}

void TextureStream::lose(uint32_t blob) {
  if (blob != set_blob_.number && !keys_.contains(blob)) return;  // a mesh or a page
  lost_.insert(blob);
  std::erase_if(missing_, [blob](const Request& request) { return request.blob.number == blob; });
}

void TextureStream::refine(std::span<const TexturedPart> parts, const View& view, float threshold_px) {
  if (!set_) return;
  const std::vector<WantedTile> wanted = wantTiles(*set_, parts, view, threshold_px);
  const size_t fitting = countFitting(*set_, wanted, cache_.budgetBytes());
  missing_.clear();
  left_out_ = wanted.size() - fitting;
  lost_in_view_ = 0;
  blob_bytes_in_use_ = set_blob_.bytes;
  refined_ = true;
  std::set<uint32_t> seen;
  std::vector<uint32_t> in_use;
  for (const WantedTile& tile : std::span(wanted).first(fitting)) {
    const BlobRef& blob = tileBlob(*set_, tile.key);
    const bool is_lost = lost_.contains(blob.number);
    lost_in_view_ += is_lost && tile.visible ? 1 : 0;
    if (is_lost || !seen.insert(blob.number).second) continue;
    if (cache_.find(blob.number)) {
      in_use.push_back(blob.number);
      blob_bytes_in_use_ += blob.bytes;
    } else {
      missing_.push_back({blob,
                          {BlobKind::kTile, {}},
                          tile.visible ? proto::RequestClass::kVisible : proto::RequestClass::kMargin,
                          tile.priority_px});
    }
  }
  cache_.use(in_use);
}

std::vector<ResidentTile> TextureStream::residentTiles() const {
  std::vector<ResidentTile> tiles;
  cache_.forEach([&](uint32_t blob, const std::shared_ptr<const TileImage>& image) {
    for (const TileKey& key : keys_.find(blob)->second.keys) tiles.push_back({key, image});
  });
  std::sort(tiles.begin(), tiles.end(),
            [](const ResidentTile& a, const ResidentTile& b) { return a.key < b.key; });
  return tiles;
}

}  // namespace lode::core
