#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "common/mesh.h"

namespace lode::ingest {

struct SampleVertex {
  glm::vec3 position{0};
  glm::vec3 normal{0};  ///< unit normal
  glm::u8vec3 colour{0};
  glm::vec2 uv{0};  ///< texture coordinates in 0..1
};

/// A procedural mesh of any size. It is computed block by block; a block has tens of thousands of vertices or
/// triangles, which depend only on the block's index. All functions are thread safe.
class SampleModel {
 public:
  /// @param attributes  attributes that the caller needs; the model may leave all others unset.
  explicit SampleModel(AttributeSet attributes) : attributes_(attributes) {}
  virtual ~SampleModel() = default;
  SampleModel(const SampleModel&) = delete;
  SampleModel& operator=(const SampleModel&) = delete;

  virtual uint64_t vertices() const = 0;
  virtual uint64_t triangles() const = 0;

  /// Returns the number of blocks, which is the same for vertices and for triangles.
  virtual uint64_t blocks() const = 0;
  /// Appends the vertices of a block.
  virtual void addVertices(uint64_t block, std::vector<SampleVertex>& to) const = 0;
  /// Appends the triangles of a block. Their indices count the vertices of the whole model. Their vertices
  /// are counter-clockwise as seen from outside a solid, or from above a terrain.
  virtual void addTriangles(uint64_t block, std::vector<glm::u32vec3>& to) const = 0;

 protected:
  bool wants(uint8_t attribute) const { return attributes_.has(attribute); }

 private:
  AttributeSet attributes_;
};

/// The range of rows in one block. Rows are the equal parts of a mesh that a block is made of: vertices, or
/// squares of a grid.
struct RowRange {
  uint64_t first = 0, end = 0;

  static constexpr uint64_t kBlockRows = 1u << 15;

  static uint64_t blocksOf(uint64_t rows) { return rows / kBlockRows + 1; }
  static RowRange ofBlock(uint64_t block, uint64_t blocks, uint64_t rows) {
    const uint64_t each = (rows + blocks - 1) / blocks;
    return {std::min(rows, block * each), std::min(rows, (block + 1) * each)};
  }
};

}  // namespace lode::ingest
