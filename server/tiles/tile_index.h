#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "server/tiles/tile_writer.h"

namespace lode::tiles {

/// Finds the parts of a store by the file names of TileWriter. Contains all files that exportTiles() writes
/// except tileset.json. Also contains images that no tile shows. Uses 16 bytes per file. Immutable and thread
/// safe.
class TileIndex {
 public:
  /// Reads the hierarchy, but decodes no payload. @param writer  must outlive the index.
  TileIndex(const store::Reader& reader, const TileWriter& writer);

  /// Finds the owner of a page by a name such as "p/0123456789abcdef0123456789abcdef.json".
  std::optional<NodeKey> findPage(std::string_view name) const;
  /// Finds an LOD by a name such as "g/0123456789abcdef0123456789abcdef.1.glb". If several LODs have equal
  /// payloads, returns one of them.
  std::optional<store::CutItem> findGlb(std::string_view name) const;

  /// Finds an image by a name such as "i/0123456789abcdef0123456789abcdef.1.jpg".
  std::optional<SharedImage> findImage(std::string_view name) const;

  uint64_t memoryBytes() const noexcept {
    return (pages_.capacity() + glbs_.capacity() + images_.capacity()) * sizeof(Entry);
  }

 private:
  struct Entry {
    uint64_t name_start = 0;  ///< first 16 hexadecimal digits of the name
    store::CutItem item;      ///< for a page, the node is the page's owner; for an image, texture and level

    friend bool operator<(const Entry& a, const Entry& b) noexcept { return a.name_start < b.name_start; }
  };

  void addBelow(const Node& node, double above_model);
  void addImages();
  static std::optional<uint64_t> startOf(std::string_view name);

  const store::Reader& reader_;
  const TileWriter& writer_;
  std::vector<Entry> pages_, glbs_, images_;  ///< sorted
};

}  // namespace lode::tiles
