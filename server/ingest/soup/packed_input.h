#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "common/mesh.h"
#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/disk/temporary_folder.h"
#include "server/ingest/ply/ply_reader.h"
#include "server/ingest/soup/uv_grid.h"

namespace lode::ingest {

/// Code that is stored instead of an octahedral code for a normal of length zero.
constexpr uint16_t kNoNormal = 0xffff;

/// Vertices and faces in temporary files, which later stages read instead of the PLY file. Vertices have a
/// fixed size, and faces are in blocks. Both are in the order of the PLY file. Attributes are quantized;
/// normals can be kNoNormal. Positions and texture coordinates are not quantized, because their grids can be
/// chosen only when all vertices are known.
class PackedInput {
 public:
  /// Names of the files, which outlive a killed build.
  static constexpr std::string_view kVertexFile = "vertices", kFaceFile = "faces";

  /// @param face_attributes  attributes that are stored per face or per corner instead of per vertex.
  PackedInput(const TemporaryFolder& folder, AttributeSet attributes, bool double_positions,
              AttributeSet face_attributes = {});

  /// Syncs a flushed input to disk and records all that load() needs.
  void save(RecordWriter& record) const;
  /// Opens the input that save() recorded. @throws Error kIo, kFormat.
  static PackedInput load(const TemporaryFolder& folder, RecordReader& record);

  AttributeSet attributes() const noexcept { return attributes_; }
  uint64_t vertexCount() const noexcept { return vertices_; }
  uint64_t faceCount() const noexcept { return faces_; }
  uint64_t temporaryBytes() const noexcept { return vertex_spool_.size() + face_spool_.size(); }

  void addVertices(std::span<const PlyVertex> vertices);
  void addFaces(const PlyFaces& faces);
  void flush();

  /// Returns the range of all texture coordinates.
  const UvRange& uvRange() const noexcept { return uv_range_; }
  /// Returns the range of the texture coordinates that faces use. Reads all faces and vertices if vertices
  /// have texture coordinates outside 0..1. The input must be flushed.
  UvRange usedUvRange() const;
  /// Sets the grid to which texture coordinates are snapped when vertices or faces are read.
  void setUvGrid(const UvGrid& grid) noexcept { uv_grid_ = grid; }
  const UvGrid& uvGrid() const noexcept { return uv_grid_; }

  /// Returns the attributes that are stored per vertex.
  AttributeSet ofVertices() const noexcept { return vertex_attributes_; }
  /// Returns true if vertices have attributes. Attributes of corners and faces do not count.
  bool hasVertexAttributes() const noexcept { return vertex_attributes_.bits != 0; }
  /// Passes vertices first..first+count to sink(number, position, attributes).
  template <typename Sink>
  void readVertices(uint64_t first, uint64_t count, Sink&& sink) const;
  size_t vertexBytes() const noexcept { return vertex_bytes_; }
  /// Reads the position of one vertex from disk. The input must be flushed.
  glm::dvec3 positionOf(uint64_t vertex) const;

  /// A block of polygons, as flat arrays. If corner_counts is empty, all polygons are triangles.
  struct FaceBlock {
    std::vector<uint32_t> corner_counts;
    std::vector<uint32_t> corners;
    std::vector<glm::u16vec2> texture;  ///< texture coordinates of each corner, or empty
    std::vector<uint16_t> materials;    ///< material of each face, or empty
    std::vector<glm::u8vec4> colours;   ///< colour of each face, or empty
    size_t faceCount() const noexcept {
      return corner_counts.empty() ? corners.size() / 3 : corner_counts.size();
    }
    uint64_t bytes() const noexcept {
      return (corner_counts.size() + corners.size()) * sizeof(uint32_t) +
             texture.size() * sizeof(glm::u16vec2) + materials.size() * sizeof(uint16_t) +
             colours.size() * sizeof(glm::u8vec4);
    }
  };
  /// Reads blocks sequentially.
  class FaceCursor {
   public:
    explicit FaceCursor(const PackedInput& input, uint64_t offset = 0);
    uint64_t offset() const noexcept { return cursor_.offset(); }  ///< offset of the next block
    bool next(FaceBlock& block);

   private:
    const PackedInput* input_;
    SpoolCursor cursor_;
    std::vector<glm::vec2> texture_;
  };

 private:
  struct Place {
    uint64_t vertex_bytes = 0, face_bytes = 0, vertices = 0, faces = 0;
    UvGrid uv_grid;
    AttributeSet attributes, face_attributes;
    uint8_t double_positions = 0;
  };
  PackedInput(const TemporaryFolder& folder, const Place& place);
  glm::dvec3 positionIn(const std::byte* vertex) const noexcept {
    glm::dvec3 position;
    glm::vec3 single;
    if (double_positions_) {
      std::memcpy(&position, vertex, sizeof(position));
    } else {
      std::memcpy(&single, vertex, sizeof(single));
      position = single;
    }
    return position;
  }

  const AttributeSet attributes_, face_attributes_;
  const bool double_positions_;
  const AttributeSet vertex_attributes_;
  const size_t vertex_bytes_;
  Spool vertex_spool_, face_spool_;
  uint64_t vertices_ = 0, faces_ = 0;
  UvRange uv_range_;
  UvGrid uv_grid_;
  std::vector<std::byte> packed_;
};

/// Returns the attributes that are stored per vertex instead of per corner or per face.
AttributeSet vertexAttributes(AttributeSet attributes, AttributeSet face_attributes) noexcept;

/// Returns the size of a vertex in temporary files.
size_t packedVertexBytes(AttributeSet vertex_attributes, bool double_positions) noexcept;

template <typename Sink>
void PackedInput::readVertices(uint64_t first, uint64_t count, Sink&& sink) const {
  SpoolCursor cursor(vertex_spool_, first * vertex_bytes_, (first + count) * vertex_bytes_);
  for (uint64_t i = first; i < first + count; ++i) {
    const std::byte* bytes = cursor.take(vertex_bytes_).data();
    const glm::dvec3 position = positionIn(bytes);
    const size_t position_bytes = double_positions_ ? sizeof(glm::dvec3) : sizeof(glm::vec3);
    VertexAttributes attributes;
    if (hasVertexAttributes()) std::memcpy(&attributes, bytes + position_bytes, sizeof(attributes));
    if (vertex_attributes_.has(AttributeSet::kTexture)) {
      glm::vec2 uv;
      std::memcpy(&uv, bytes + position_bytes + sizeof(attributes), sizeof(uv));
      attributes.texture = uv_grid_.snap(uv);
    }
    sink(i, position, attributes);
  }
}

}  // namespace lode::ingest
