#include "server/tiles/tile_index.h"

#include <algorithm>
#include <charconv>

#include "server/tiles/texture_levels.h"

namespace lode::tiles {

namespace {

constexpr size_t kFolderBytes = 2, kStartDigits = 16;

}  // namespace

TileIndex::TileIndex(const store::Reader& reader, const TileWriter& writer)
    : reader_(reader), writer_(writer) {
  addBelow(reader.nodes().front(), writer.errorOfTileset());
  if (writer.hasImages()) addImages();
  for (std::vector<Entry>* entries : {&pages_, &glbs_, &images_}) {
    std::ranges::stable_sort(*entries, std::less<>());
    entries->shrink_to_fit();
  }
}

/// Adds the tiles and pages of a node and of its descendants. @param above_model  see tileChain().
void TileIndex::addBelow(const Node& node, double above_model) {
  const auto number = static_cast<uint32_t>(&node - reader_.nodes().data());
  const std::vector<TileLod> chain = tileChain(node, above_model);
  for (const TileLod& tile : chain) {
    if (node.lods[tile.lod].payload)
      glbs_.push_back({*startOf(writer_.glbName({number, tile.lod})), {number, tile.lod}});
  }
  if (!continuesBelow(node, chain)) return;
  if (node.child_page) pages_.push_back({*startOf(writer_.pageName(node.key)), {number, 0}});
  for (unsigned octant = 0; octant < 8; ++octant) {
    if ((node.child_mask >> octant & 1) == 0) continue;
    const Node* const child = reader_.find(node.key.child(octant));
    if (child != nullptr && !child->box.empty()) addBelow(*child, chain.back().error_model);
  }
}

void TileIndex::addImages() {
  const TextureLevels levels(reader_);
  for (uint32_t i = 0; i < reader_.textures().textures.size(); ++i) {
    if (reader_.textures().textures[i].tiles.empty()) continue;
    for (uint32_t level = 0; level <= levels.coarsest(i); ++level)
      images_.push_back({*startOf(writer_.imageName({i, level})), {i, level}});
  }
}

/// Parses the first 16 hexadecimal digits after the folder in a name. Returns nothing for other characters.
std::optional<uint64_t> TileIndex::startOf(std::string_view name) {
  if (name.size() < kFolderBytes + kStartDigits) return {};
  const std::string_view digits = name.substr(kFolderBytes, kStartDigits);
  uint64_t start = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), start, 16);
  if (error != std::errc() || end != digits.data() + digits.size()) return {};
  return start;
}

std::optional<NodeKey> TileIndex::findPage(std::string_view name) const {
  const std::optional<uint64_t> start = startOf(name);
  if (!start) return {};
  const auto [first, last] = std::equal_range(pages_.begin(), pages_.end(), Entry{*start, {}});
  for (auto entry = first; entry != last; ++entry) {
    const NodeKey owner = reader_.nodes()[entry->item.node].key;
    if (writer_.pageName(owner) == name) return owner;
  }
  return {};
}

std::optional<store::CutItem> TileIndex::findGlb(std::string_view name) const {
  const std::optional<uint64_t> start = startOf(name);
  if (!start) return {};
  const auto [first, last] = std::equal_range(glbs_.begin(), glbs_.end(), Entry{*start, {}});
  for (auto entry = first; entry != last; ++entry)
    if (writer_.glbName(entry->item) == name) return entry->item;
  return {};
}

std::optional<SharedImage> TileIndex::findImage(std::string_view name) const {
  const std::optional<uint64_t> start = startOf(name);
  if (!start) return {};
  const auto [first, last] = std::equal_range(images_.begin(), images_.end(), Entry{*start, {}});
  for (auto entry = first; entry != last; ++entry) {
    const SharedImage image{entry->item.node, entry->item.lod};
    if (writer_.imageName(image) == name) return image;
  }
  return {};
}

}  // namespace lode::tiles
