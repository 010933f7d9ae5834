#include "client/render/residency/texture_residency.h"

#include <algorithm>
#include <chrono>
#include <cstring>

#include "client/core/textures/texture_wants.h"
#include "client/core/textures/tile.h"

namespace lode::render {
namespace {

constexpr uint32_t kFirstLayers = 4;  // initial number of layers of the array; the number doubles when the
                                      // array is full
constexpr uint32_t kHeadWords = 4;    // number of words of a texture's header in the table
constexpr uint32_t kResidentBit = 1u << 31;

/// Encodes the layer and corner of a resident tile as an entry of the table.
uint32_t pageOf(const TileCell& cell) {
  return kResidentBit | cell.layer << 8 | cell.corner.y / core::kLeastTileCellPx << 4 |
         cell.corner.x / core::kLeastTileCellPx;
}

size_t tailLevels(const Texture& texture) {
  return core::tailSizes(levelSize(texture, levelCount(texture) - 1) + 2 * kTileGutterPx).size();
}

uint64_t texelBytes(const TileImage& image) {
  uint64_t texels = image.texels.size();
  for (const TileImage& coarser : image.coarser) texels += coarser.texels.size();
  return texels * sizeof(glm::u8vec4);
}

/// Returns true if no texel is transparent. Checks only the finest level, because the texels of coarser
/// levels are means of its texels.
bool isOpaque(const TileImage& image) {
  return std::ranges::all_of(image.texels, [](const glm::u8vec4& texel) { return texel.a == 255; });
}

uint32_t layersOf(uint64_t budget_bytes) {
  GLint limit = 0;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &limit);
  const uint64_t layers = std::max<uint64_t>(budget_bytes / kTileLayerBytes, 1);
  return static_cast<uint32_t>(std::min<uint64_t>(layers, static_cast<uint64_t>(limit)));
}

}  // namespace

std::optional<TileCell> TileCells::allocate(glm::uvec2 size) {
  static_assert(edgeOf(kOrders - 1) == core::kLeastTileCellPx);
  uint32_t wanted = kOrders - 1;
  while (wanted > 0 && edgeOf(wanted) < std::max(size.x, size.y)) --wanted;
  uint32_t order = wanted;
  while (order > 0 && free_[order].empty()) --order;
  if (free_[order].empty()) {
    if (layers_ >= most_layers_) return std::nullopt;
    free_[0].insert({layers_++, 0, 0});
  }
  const auto [layer, y, x] = *free_[order].begin();
  free_[order].erase(free_[order].begin());
  while (order < wanted) {
    const uint32_t edge = edgeOf(++order);
    free_[order].insert({{layer, y, x + edge}, {layer, y + edge, x}, {layer, y + edge, x + edge}});
  }
  return TileCell{layer, {x, y}, edgeOf(wanted)};
}

void TileCells::release(const TileCell& cell) {
  uint32_t order = 0;
  while (edgeOf(order) > cell.edge) ++order;
  glm::uvec2 corner = cell.corner;
  for (;; --order) {
    std::set<Place>& free = free_[order];
    free.insert({cell.layer, corner.y, corner.x});
    if (order == 0) return;
    const uint32_t edge = edgeOf(order);
    corner = corner / (2 * edge) * (2 * edge);
    const Place quarters[] = {{cell.layer, corner.y, corner.x},
                              {cell.layer, corner.y, corner.x + edge},
                              {cell.layer, corner.y + edge, corner.x},
                              {cell.layer, corner.y + edge, corner.x + edge}};
    if (!std::all_of(std::begin(quarters), std::end(quarters),
                     [&](const Place& q) { return free.contains(q); }))
      return;
    for (const Place& quarter : quarters) free.erase(quarter);
  }
}

TextureResidency::TextureResidency(uint64_t budget_bytes, uint32_t staging_bytes)
    : cells_(layersOf(budget_bytes)), most_layers_(layersOf(budget_bytes)), staging_bytes_(staging_bytes) {}

void TextureResidency::setBudget(uint64_t bytes) {
  const uint32_t layers = layersOf(bytes);
  if (layers == most_layers_) return;
  most_layers_ = layers;
  cut_.reset();
  waiting_.clear();
  if (layers >= array_layers_) return cells_.allow(layers);
  release();
}

void TextureResidency::release() {
  cut_.reset();
  drawn_.reset();
  waiting_.clear();
  array_ = {};
  array_layers_ = 0;
  takeSet(nullptr);
}

/// Builds the table. The table begins with one header per texture: width, height, number of levels including
/// the tail (see client/core/textures/tile.h), and index of the texture's level list. The level lists and
/// entries of all textures follow. A level list has the index of each level's first entry. Each tile and each
/// tail level has an entry, which pageOf() encodes; the entry of a missing tile is 0.
void TextureResidency::takeSet(std::shared_ptr<const TextureSet> set) {
  set_ = std::move(set);
  entries_.clear();
  cells_ = TileCells(most_layers_);
  first_entries_.clear();
  has_clear_ = false;
  if (!set_) return;
  std::vector<uint32_t> table(set_->textures.size() * kHeadWords);
  for (size_t i = 0; i < set_->textures.size(); ++i) {
    const Texture& texture = set_->textures[i];
    const uint32_t stored = levelCount(texture);
    const size_t tail = stored == 0 ? 0 : tailLevels(texture);
    const auto levels = static_cast<uint32_t>(stored + tail);
    const auto places = static_cast<uint32_t>(table.size());
    const uint32_t first = places + levels;
    const uint32_t head[kHeadWords] = {texture.width, texture.height, levels, places};
    std::copy(std::begin(head), std::end(head), table.begin() + static_cast<std::ptrdiff_t>(i * kHeadWords));
    for (uint32_t level = 0; level < stored; ++level)
      table.push_back(first + static_cast<uint32_t>(tileIndex(texture, level, 0, 0)));
    for (uint32_t level = 0; level < tail; ++level)
      table.push_back(first + static_cast<uint32_t>(texture.tiles.size()) + level);
    first_entries_.push_back(first);
    table.resize(table.size() + texture.tiles.size() + tail, 0);
  }
  if (table.empty()) table.push_back(0);
  table_ = GlBuffer::create();
  glNamedBufferStorage(table_.get(), static_cast<GLsizeiptr>(table.size() * sizeof(uint32_t)), table.data(),
                       GL_DYNAMIC_STORAGE_BIT);
  if (!staging_) staging_.emplace(staging_bytes_);
}

/// Sets a tile's entries in the table. @param cells  cells of the tile; empty if the tile was evicted.
void TextureResidency::setPages(const core::TileKey& key, std::span<const TileCell> cells) {
  const Texture& texture = set_->textures[key.texture];
  const auto write = [this](size_t index, uint32_t page) {
    glNamedBufferSubData(table_.get(), static_cast<GLintptr>(index * sizeof page), sizeof page, &page);
  };
  const size_t first = first_entries_[key.texture];
  write(first + tileIndex(texture, key.level, key.x, key.y), cells.empty() ? 0 : pageOf(cells[0]));
  if (key.level + 1 < levelCount(texture)) return;
  for (size_t i = 0; i < tailLevels(texture); ++i)
    write(first + texture.tiles.size() + i, i + 1 < cells.size() ? pageOf(cells[i + 1]) : 0);
}

void TextureResidency::show(const std::shared_ptr<const core::Cut>& newest,
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
void TextureResidency::evictUnused() {
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

/// Evicts all images and queues the tiles of the cut for upload, the largest first. This order leaves no gaps
/// between cells.
void TextureResidency::repack() {
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

uint64_t TextureResidency::uploadInRenderThread(const UploadBudget& budget) {
  if (waiting_.empty()) return 0;
  const auto start = std::chrono::steady_clock::now();
  const auto spent_ms = [start] {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  };
  uint64_t uploaded_bytes = 0;
  do {
    if (!staging_->open(budget.wait)) break;
    uint32_t left_bytes = staging_bytes_;
    while (!waiting_.empty()) {
      const core::ResidentTile tile = waiting_.back();
      const auto bytes = static_cast<uint32_t>(texelBytes(*tile.image));
      const bool over =
          uploaded_bytes != 0 && (uploaded_bytes + bytes > budget.bytes || spent_ms() > budget.ms);
      if (bytes > left_bytes || (over && !budget.wait)) break;
      waiting_.pop_back();
      if (!upload(tile)) continue;
      left_bytes -= bytes;
      uploaded_bytes += bytes;
    }
    staging_->close();
  } while (budget.wait && !waiting_.empty());
  return uploaded_bytes;
}

/// Uploads the image of a tile. @return true if the image was uploaded, false if it was already resident or
/// does not fit.
bool TextureResidency::upload(const core::ResidentTile& tile) {
  if (const auto same = entries_.find(tile.image); same != entries_.end()) {
    same->second.keys.push_back(tile.key);
    setPages(tile.key, same->second.cells);
    return false;
  }
  std::vector<TileCell> cells = allocate(*tile.image);
  if (cells.empty()) {
    if (!repacked_) repack();
    return false;
  }
  if (cells_.layers() > array_layers_ && !growTo(cells_.layers())) {
    repack();
    return false;
  }
  copy(*tile.image, cells[0]);
  for (size_t i = 1; i < cells.size(); ++i) copy(tile.image->coarser[i - 1], cells[i]);
  has_clear_ = has_clear_ || !isOpaque(*tile.image);
  setPages(tile.key, cells);
  entries_.emplace(tile.image, Entry{std::move(cells), {tile.key}});
  return true;
}

/// Allocates cells. @return a cell for the image and one for each of its coarser levels, or no cells if not
/// all of them fit.
std::vector<TileCell> TextureResidency::allocate(const TileImage& image) {
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

void TextureResidency::release(std::span<const TileCell> cells) {
  for (const TileCell& cell : cells) cells_.release(cell);
}

void TextureResidency::copy(const TileImage& image, const TileCell& cell) {
  const std::span<const std::byte> texels = std::as_bytes(std::span(image.texels));
  const std::span<std::byte> room = staging_->take(static_cast<uint32_t>(texels.size()));
  std::memcpy(room.data(), texels.data(), texels.size());
  staging_->copyTo(array_.get(), static_cast<GLint>(cell.layer), glm::ivec2(cell.corner),
                   glm::ivec2(image.size));
}

/// Grows the array. While the old array is copied, both arrays take memory. An array that would exceed half
/// the limit therefore gets the whole limit at once, so that only smaller arrays are ever copied.
/// @return false if the driver is out of memory; the array then stays as it is.
bool TextureResidency::growTo(uint32_t layers) {
  uint32_t wanted = std::min(most_layers_, std::max({layers, 2 * array_layers_, kFirstLayers}));
  if (2 * wanted > most_layers_) wanted = most_layers_;
  while (glGetError() != GL_NO_ERROR) {
  }
  GlTextureArray array = GlTextureArray::create();
  glTextureStorage3D(array.get(), 1, GL_SRGB8_ALPHA8, GLsizei{kTilePx}, GLsizei{kTilePx},
                     static_cast<GLsizei>(wanted));
  if (glGetError() != GL_NO_ERROR) {
    most_layers_ = array_layers_;
    return false;
  }
  glTextureParameteri(array.get(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(array.get(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(array.get(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(array.get(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  if (array_layers_ != 0) {
    glCopyImageSubData(array_.get(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, array.get(), GL_TEXTURE_2D_ARRAY, 0, 0,
                       0, 0, GLsizei{kTilePx}, GLsizei{kTilePx}, static_cast<GLsizei>(array_layers_));
  }
  array_ = std::move(array);
  array_layers_ = wanted;
  return true;
}

void TextureResidency::bind() const {
  glBindTextureUnit(0, array_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, table_.get());
}

}  // namespace lode::render
