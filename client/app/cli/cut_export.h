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

/// The textures of an exported mesh and their image files.
struct CutImages {
  ImageFiles files;  ///< image file of each texture; a texture without an image file has width and height 0
  /// Names of the textures that the mesh uses but whose coarsest tile is not resident.
  std::vector<std::string> left_out;
};

/// Writes the textures that a cut's mesh uses as PNG files beside the mesh file. Each image is as sharp as
/// the texture's resident tiles: see ResidentImage. ImageNames chooses the file names. @throws Error kIo;
/// kUsage if the mesh file is a pipe or a device.
CutImages writeCutImages(const core::Cut& cut, const Mesh& mesh, const std::filesystem::path& mesh_file);

/// Joins the parts of a cut into one mesh. Merges vertices that have equal positions and attributes. Vertices
/// and triangles keep the order of the parts. @throws Error as MeshJoiner::add().
Mesh weldCut(const core::Cut& cut, AttributeSet attributes);

/// The image of a texture, composed of the texture's resident tiles. The image has the size of the finest
/// level that has a resident tile. Where a tile of this level is missing, a resident tile of a coarser level
/// is magnified to take its place.
class ResidentImage {
 public:
  /// @param number  index of the texture, which selects its tiles.
  /// @param tiles   resident tiles of all textures. The tiles and the texture must outlive this object.
  ResidentImage(const Texture& texture, uint32_t number, std::span<const core::ResidentTile> tiles);

  /// Returns true if the coarsest level is resident, so that every texel has a colour. Call the other
  /// functions only if this one returns true.
  bool isComplete() const noexcept;
  glm::uvec2 size() const { return levelSize(texture_, finest_); }
  /// Returns true if any texel is not opaque.
  bool hasAlpha() const;
  /// Fills a buffer with one row of the image. @param y  index of the row from the top.
  /// @param row  buffer of size().x texels.
  void fill(uint32_t y, std::span<glm::u8vec4> row) const;

 private:
  struct Level {
    uint32_t across = 0;
    std::vector<const TileImage*> tiles;  // row by row; null if the tile is not resident
  };
  void fill(uint32_t level, uint32_t y, uint32_t first, uint32_t end, std::span<glm::u8vec4> row) const;

  const Texture& texture_;
  std::vector<Level> levels_;
  uint32_t finest_ = 0;
};

}  // namespace lode::app
