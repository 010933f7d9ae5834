#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "server/http/content_cache.h"
#include "server/store/reader.h"
#include "server/tiles/tile_index.h"
#include "server/tiles/tile_writer.h"

namespace lode::http {

/// A store as 3D Tiles. Makes the same files as `export --tiles`. Immutable and thread safe.
class Tileset : public Content {
 public:
  /// Guesses the up axis from the coarsest mesh, and reads the hierarchy. @throws Error kIo, kFormat, kLimit.
  explicit Tileset(std::shared_ptr<const store::Reader> store);

  /// Returns true if export writes a file with this name, such as "tileset.json" or "g/BLOB.V.glb".
  bool has(std::string_view file) const;
  /// Makes a file. JSON files are also compressed. @param file  name for which has() returns true.
  /// @throws Error kIo, kFormat, kLimit, naming file and node; kInternal.
  std::unique_ptr<const Content> make(std::string_view file) const;

  uint64_t memoryBytes() const noexcept override { return sizeof *this + index_.memoryBytes(); }

 private:
  std::shared_ptr<const store::Reader> store_;
  tiles::TileWriter writer_;
  tiles::TileIndex index_;
};

}  // namespace lode::http
