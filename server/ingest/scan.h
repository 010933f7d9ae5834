#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "common/lattice.h"
#include "common/mesh.h"
#include "server/ingest/build.h"
#include "server/ingest/ply_reader.h"
#include "server/ingest/spool.h"
#include "server/ingest/temporary_folder.h"

namespace lode::ingest {

/// The input, packed: what later stages read instead of the PLY. Vertices have a fixed size, faces lie in
/// blocks, both in the file's order. Attributes are quantized already; positions are not yet: the lattice
/// follows from them.
class PackedInput {
 public:
  PackedInput(const TemporaryFolder& folder, AttributeSet attributes, bool double_positions);

  AttributeSet attributes() const noexcept { return attributes_; }
  uint64_t vertexCount() const noexcept { return vertices_; }
  uint64_t faceCount() const noexcept { return faces_; }
  uint64_t temporaryBytes() const noexcept { return vertex_spool_.size() + face_spool_.size(); }

  void addVertices(std::span<const PlyVertex> vertices);
  void addFaces(const PlyFaces& faces);
  void flush();

  /// Vertices first..first+count, to a sink of (number, position, attributes).
  template <typename Sink>
  void readVertices(uint64_t first, uint64_t count, Sink&& sink) const;
  size_t vertexBytes() const noexcept { return vertex_bytes_; }

  /// Polygons as flat arrays; triangles only where corner_counts is empty.
  struct FaceBlock {
    std::vector<uint32_t> corner_counts;
    std::vector<uint32_t> corners;
    size_t faceCount() const noexcept {
      return corner_counts.empty() ? corners.size() / 3 : corner_counts.size();
    }
  };
  /// Reads blocks from front to end.
  class FaceCursor {
   public:
    explicit FaceCursor(const PackedInput& input);
    bool next(FaceBlock& block);

   private:
    SpoolCursor cursor_;
  };

 private:
  const AttributeSet attributes_;
  const bool double_positions_;
  const size_t vertex_bytes_;
  Spool vertex_spool_, face_spool_;
  uint64_t vertices_ = 0, faces_ = 0;
  std::vector<std::byte> packed_;
};

/// Of a file's attributes, those that a build keeps.
AttributeSet keptAttributes(AttributeSet file) noexcept;

/// Whether the file's positions need more than float.
bool hasDoublePositions(const PlyHeader& header);

struct ScannedModel {
  PackedInput input;
  PlyCounts counts;
};

/// Stage 1: reads the PLY file once and packs it.
ScannedModel scan(const BuildOptions& options, const TemporaryFolder& folder, const BuildProgress& progress,
                  std::vector<std::string>& warnings);

template <typename Sink>
void PackedInput::readVertices(uint64_t first, uint64_t count, Sink&& sink) const {
  SpoolCursor cursor(vertex_spool_, first * vertex_bytes_, (first + count) * vertex_bytes_);
  for (uint64_t i = first; i < first + count; ++i) {
    const std::byte* bytes = cursor.take(vertex_bytes_).data();
    glm::dvec3 position;
    size_t position_bytes = sizeof(glm::dvec3);
    if (double_positions_) {
      std::memcpy(&position, bytes, sizeof(position));
    } else {
      glm::vec3 single;
      std::memcpy(&single, bytes, sizeof(single));
      position = single;
      position_bytes = sizeof(single);
    }
    VertexAttributes attributes;
    if (vertex_bytes_ > position_bytes) std::memcpy(&attributes, bytes + position_bytes, sizeof(attributes));
    sink(i, position, attributes);
  }
}

}  // namespace lode::ingest
