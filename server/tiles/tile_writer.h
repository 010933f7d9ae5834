#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "server/store/cut.h"
#include "server/store/reader.h"
#include "server/tiles/lod_chain.h"
#include "server/tiles/tile_textures.h"

namespace lode::tiles {

/// One JSON file of a tileset, and the files to which it refers.
struct TilesetPage {
  std::string json;
  std::vector<store::CutItem> contents;  ///< tiles with triangles, each in a GLB of its own
  std::vector<NodeKey> pages;            ///< owners of the pages below
  uint64_t tiles = 0;                    ///< number of tiles with content
};

/// A GLB, and the image files to which it refers.
struct TileGlb {
  std::vector<std::byte> bytes;
  std::vector<SharedImage> images;
};

/// Converts parts of a store to the files of a tileset in the format 3D Tiles 1.1. All functions are pure:
/// the bytes of a file depend only on the store, the root's transform and the arguments. Except for
/// tileset.json, a file's name depends on its contents, so that caches can keep it forever. Thread safe.
///
/// A node's LODs form a chain of tiles from the coarsest to the finest, each the only child of the one before
/// (tileChain()). The finest tile's children are the chains of the node's children. Refinement replaces a
/// tile by its children, so a viewer always draws a cut of the store, without cracks. Each page of the
/// store's hierarchy is an external tileset.
class TileWriter {
 public:
  /// @param reader  must outlive the writer.
  /// @throws Error kIo or kFormat if a texture of the store cannot be read.
  TileWriter(const store::Reader& reader, const glm::dmat4& root_transform);

  /// Returns the page of an owner (store::pageOwner()).
  TilesetPage page(NodeKey owner) const;
  /// Returns "tileset.json" for the root's page, else a path like "p/0123456789abcdef0123456789abcdef.json".
  std::string pageName(NodeKey owner) const;

  /// Returns the GLB of an LOD with triangles. @throws Error kIo, kFormat or kLimit, naming file and node.
  TileGlb glb(store::CutItem item) const;
  /// Returns a path like "g/0123456789abcdef0123456789abcdef.1.glb".
  std::string glbName(store::CutItem item) const;

  /// Returns a JPEG or WebP file. @throws Error kIo, kFormat or kLimit, naming the store's file.
  std::vector<std::byte> image(SharedImage image) const;
  /// Returns true if the store has textures that tiles show.
  bool hasImages() const noexcept { return has_images_; }
  /// Returns a path like "i/0123456789abcdef0123456789abcdef.1.jpg".
  std::string imageName(SharedImage image) const;

  /// Returns the geometricError of the tileset, in model units. It is above the error of the root's tile.
  double errorOfTileset() const;

 private:
  class PageMaker;
  /// Parts of the names of a texture's images.
  struct NamedTexture {
    Digest digest;
    const char* extension = "";
  };

  const Node& nodeOf(NodeKey key) const;
  std::string pageName(const Node& owner, double error_model) const;
  /// Returns the error of the finest tile of a node.
  double finestError(NodeKey key) const;

  const store::Reader& reader_;
  const glm::dmat4 root_transform_;
  std::vector<NamedTexture> textures_;  ///< empty if the vertices have no texture coordinates
  bool has_images_ = false;
};

}  // namespace lode::tiles
