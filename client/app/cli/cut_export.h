#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/lod/cut.h"
#include "common/codec/texture_set.h"
#include "common/io/mesh_materials.h"
#include "common/mesh.h"

namespace lode::app {

/// Textures of an exported mesh.
struct CutImages {
  ImageFiles files;  ///< image file of each texture; a texture without a file has no image
  /// Names of the textures that the mesh uses but that have no resident tile.
  std::vector<std::string> left_out;
};

/// Writes the images of a cut's mesh as PNG files beside the mesh file. The images are as sharp as their
/// resident tiles; see ResidentImage and ImageNames. @throws Error kIo; kUsage if the mesh file is a pipe or
/// a device.
CutImages writeCutImages(const core::Cut& cut, const Mesh& mesh, const std::filesystem::path& mesh_file);

/// Joins the parts of a cut into one mesh. Equal wedges of different parts become one vertex. Vertices and
/// triangles keep the order of the parts. @throws Error as MeshJoiner::add().
Mesh weldCut(const core::Cut& cut, AttributeSet attributes);

/// The image of a texture, composed of the texture's resident tiles. The image has the size of the finest
/// level that has a resident tile. A missing tile is replaced by the next coarser level whose tile is
/// resident, magnified.
class ResidentImage {
 public:
  /// @param tiles  tiles of this texture and of others. The tiles and the texture must outlive this object.
  ResidentImage(const Texture& texture, uint32_t number, std::span<const core::ResidentTile> tiles);

  /// Returns true if the coarsest level is resident, so that every texel has a colour. Call the other
  /// functions only if this one returns true.
  bool isComplete() const noexcept;
  glm::uvec2 size() const { return levelSize(texture_, finest_); }
  /// Returns true if a texel is not opaque.
  bool hasAlpha() const;
  /// Fills a row as wide as the image. @param y  number of the row, counted from the top.
  void fill(uint32_t y, std::span<glm::u8vec4> row) const;

 private:
  struct Level {
    uint32_t across = 0;
    std::vector<const TileImage*> tiles;  // tiles row by row; null: the tile is not resident
  };
  void fill(uint32_t level, uint32_t y, uint32_t first, uint32_t end, std::span<glm::u8vec4> row) const;

  const Texture& texture_;
  std::vector<Level> levels_;
  uint32_t finest_ = 0;
};

}  // namespace lode::app
