#include "client/render/residency/tile_placement.h"

#include <algorithm>
#include <optional>
#include <set>

#include "client/core/textures/texture_wants.h"

namespace lode::render {
namespace {

constexpr uint32_t kHeadWords = 4;  // number of words of a texture's header in the table
constexpr uint32_t kResidentBit = 1u << 31;

/// Encodes the layer and corner of a resident tile as an entry of the table.
uint32_t pageOf(const TileCell& cell) {
  return kResidentBit | cell.layer << 8 | cell.corner.y / core::kLeastTileCellPx << 4 |
         cell.corner.x / core::kLeastTileCellPx;
}

size_t tailLevels(const Texture& texture) {
  return core::tailSizes(levelSize(texture, levelCount(texture) - 1) + 2 * kTileGutterPx).size();
}

/// Returns true if no texel is transparent. Checks only the finest level, because the texels of coarser
/// levels are means of its texels.
bool isOpaque(const TileImage& image) {
  return std::ranges::all_of(image.texels, [](const glm::u8vec4& texel) { return texel.a == 255; });
}

}  // namespace

void TilePlacement::allow(uint32_t most_layers) {
  most_layers_ = most_layers;
  cut_.reset();
  waiting_.clear();
  cells_.allow(most_layers);
}

void TilePlacement::clear() {
  cut_.reset();
  drawn_.reset();
  waiting_.clear();
  takeSet(nullptr);
}

void TilePlacement::takeSet(std::shared_ptr<const TextureSet> set) {
  set_ = std::move(set);
  entries_.clear();
  cells_ = TileCells(most_layers_);
  first_entries_.clear();
  table_.clear();
  changed_words_.clear();
  ++table_serial_;
  has_clear_ = false;
  if (!set_) return;
  table_.assign(set_->textures.size() * kHeadWords, 0);
  for (size_t i = 0; i < set_->textures.size(); ++i) {
    const Texture& texture = set_->textures[i];
    const uint32_t stored = levelCount(texture);
    const size_t tail = stored == 0 ? 0 : tailLevels(texture);
    const auto levels = static_cast<uint32_t>(stored + tail);
    const auto places = static_cast<uint32_t>(table_.size());
    const uint32_t first = places + levels;
    const uint32_t head[kHeadWords] = {texture.width, texture.height, levels, places};
    std::copy(std::begin(head), std::end(head), table_.begin() + static_cast<std::ptrdiff_t>(i * kHeadWords));
    for (uint32_t level = 0; level < stored; ++level)
      table_.push_back(first + static_cast<uint32_t>(tileIndex(texture, level, 0, 0)));
    for (uint32_t level = 0; level < tail; ++level)
      table_.push_back(first + static_cast<uint32_t>(texture.tiles.size()) + level);
    first_entries_.push_back(first);
    table_.resize(table_.size() + texture.tiles.size() + tail, 0);
  }
}

/// Sets a tile's entries in the table. @param cells  cells of the tile; empty if the tile was evicted.
void TilePlacement::setPages(const core::TileKey& key, std::span<const TileCell> cells) {
  const Texture& texture = set_->textures[key.texture];
  const auto write = [this](size_t index, uint32_t page) {
    table_[index] = page;
    changed_words_.push_back(index);
  };
  const size_t first = first_entries_[key.texture];
  write(first + tileIndex(texture, key.level, key.x, key.y), cells.empty() ? 0 : pageOf(cells[0]));
  if (key.level + 1 < levelCount(texture)) return;
  for (size_t i = 0; i < tailLevels(texture); ++i)
    write(first + texture.tiles.size() + i, i + 1 < cells.size() ? pageOf(cells[i + 1]) : 0);
}

void TilePlacement::show(const std::shared_ptr<const core::Cut>& newest,
                         const std::shared_ptr<const core::Cut>& drawn) {
  const bool is_other_set = drawn && drawn->textures && newest && newest->textures != drawn->textures;
  const std::shared_ptr<const core::Cut>& wanted = is_other_set ? drawn : newest;
  if (!wanted || (wanted == cut_ && drawn == drawn_)) return;
  drawn_ = drawn;
  if (wanted != cut_) {
    cut_ = wanted;
    if (cut_->textures != set_) takeSet(cut_->textures);
    waiting_.clear();
    repacked_ = false;
    if (!set_) return;
    for (const core::ResidentTile& tile : cut_->tiles) {
      const auto entry = entries_.find(tile.image);
      if (entry == entries_.end() ||
          std::ranges::find(entry->second.keys, tile.key) == entry->second.keys.end())
        waiting_.push_back(tile);
    }
    std::reverse(waiting_.begin(), waiting_.end());
  }
  evictUnused();
}

/// Evicts images that neither the newest nor the drawn cut uses.
void TilePlacement::evictUnused() {
  std::set<std::weak_ptr<const TileImage>, std::owner_less<>> kept;
  for (const core::ResidentTile& tile : cut_->tiles) kept.insert(tile.image);
  if (drawn_ && drawn_->textures == set_)
    for (const core::ResidentTile& tile : drawn_->tiles) kept.insert(tile.image);
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    if (kept.contains(entry->first)) {
      ++entry;
      continue;
    }
    for (const core::TileKey& key : entry->second.keys) setPages(key, {});
    release(entry->second.cells);
    entry = entries_.erase(entry);
  }
}

void TilePlacement::repack(uint32_t most_layers) {
  most_layers_ = most_layers;
  for (const auto& [image, entry] : entries_)
    for (const core::TileKey& key : entry.keys) setPages(key, {});
  entries_.clear();
  cells_ = TileCells(most_layers_);
  waiting_ = cut_->tiles;
  std::stable_sort(waiting_.begin(), waiting_.end(), [](const auto& a, const auto& b) {
    return core::tileRoomBytes(*a.image) < core::tileRoomBytes(*b.image);
  });
  repacked_ = true;
}

std::span<const TileCell> TilePlacement::place() {
  const core::ResidentTile tile = std::move(waiting_.back());
  waiting_.pop_back();
  if (const auto same = entries_.find(tile.image); same != entries_.end()) {
    same->second.keys.push_back(tile.key);
    setPages(tile.key, same->second.cells);
    return {};
  }
  std::vector<TileCell> cells = allocate(*tile.image);
  if (cells.empty()) {
    if (!repacked_) repack(most_layers_);
    return {};
  }
  has_clear_ = has_clear_ || !isOpaque(*tile.image);
  setPages(tile.key, cells);
  const auto entry = entries_.emplace(tile.image, Entry{std::move(cells), {tile.key}}).first;
  return entry->second.cells;
}

/// Allocates cells. @return a cell for the image and one for each of its coarser levels, or no cells if not
/// all of them fit.
std::vector<TileCell> TilePlacement::allocate(const TileImage& image) {
  std::vector<TileCell> cells;
  for (size_t i = 0; i <= image.coarser.size(); ++i) {
    const std::optional<TileCell> cell = cells_.allocate(i == 0 ? image.size : image.coarser[i - 1].size);
    if (!cell) {
      release(cells);
      return {};
    }
    cells.push_back(*cell);
  }
  return cells;
}

void TilePlacement::release(std::span<const TileCell> cells) {
  for (const TileCell& cell : cells) cells_.release(cell);
}

}  // namespace lode::render
