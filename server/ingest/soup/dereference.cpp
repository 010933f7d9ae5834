#include "server/ingest/soup/dereference.h"

#include <algorithm>
#include <optional>

#include "common/octahedral.h"
#include "server/ingest/soup/face_batch.h"
#include "server/ingest/soup/triangulate.h"

namespace lode::ingest {
namespace {

/// Faces of one batch, and what is wanted of the vertices that they use.
class Batch {
 public:
  Batch(const PackedInput& input, const Lattice& lattice, uint64_t memory_bytes)
      : input_(input),
        lattice_(lattice),
        faces_(input, memory_bytes,
               sizeof(PositionCode) + (input.hasVertexAttributes() ? sizeof(VertexAttributes) : 0)) {}

  bool readFaces(PackedInput::FaceCursor& cursor) { return faces_.read(cursor); }

  void sweepVertices(DereferenceCounts& counts) {
    positions_.resize(faces_.members());
    if (input_.hasVertexAttributes()) attributes_.resize(faces_.members());
    uint64_t next = 0;
    faces_.sweep([&](uint64_t, glm::dvec3 position, const VertexAttributes& attributes) {
      const glm::uvec3 snapped = lattice_.snap(position);
      positions_[next] = packPosition(snapped);
      counts.snap_error_steps = std::max(counts.snap_error_steps,
                                         glm::distance(position, lattice_.toWorld(snapped)) / lattice_.step);
      if (!attributes_.empty()) attributes_[next] = attributes;
      ++next;
    });
  }

  const std::vector<PackedInput::FaceBlock>& blocks() const noexcept { return faces_.blocks(); }

  /// Gives out the triangles of a block's faces.
  void giveOut(const PackedInput::FaceBlock& block, DereferenceCounts& counts, const SoupSink& sink) {
    size_t number = 0;
    forEachFace(block, [&](size_t first, uint32_t corners) {
      const uint16_t material = block.materials.empty() ? uint16_t{0} : block.materials[number];
      giveOut(block, Face{static_cast<uint32_t>(first), corners, material}, counts, sink);
      ++number;
    });
  }

 private:
  /// Of a block.
  struct Face {
    uint32_t first, corners;
    uint16_t material;
  };

  glm::dvec3 placeOf(const PackedInput::FaceBlock& block, uint32_t corner) const {
    return unpackPosition(positions_[faces_.rank(block.corners[corner])]);
  }

  void giveOut(const PackedInput::FaceBlock& block, const Face& face, DereferenceCounts& counts,
               const SoupSink& sink) {
    normal_of_face_.reset();
    if (face.corners == 3) {
      giveOut(block, face, face.first + glm::u32vec3(0, 1, 2), counts, sink);
      return;
    }
    outline_.clear();
    for (uint32_t c = 0; c < face.corners; ++c) outline_.push_back(placeOf(block, face.first + c));
    triangulate(outline_, cut_);
    for (const glm::u32vec3& t : cut_) giveOut(block, face, face.first + t, counts, sink);
  }

  /// Once a face: one of very many corners asks for it at each.
  uint16_t normalOf(const PackedInput::FaceBlock& block, const Face& face) {
    if (normal_of_face_) return *normal_of_face_;
    const glm::dvec3 from = placeOf(block, face.first);
    glm::dvec3 front(0);
    for (uint32_t c = 2; c < face.corners; ++c)
      front += glm::cross(placeOf(block, face.first + c - 1) - from, placeOf(block, face.first + c) - from);
    return normal_of_face_.emplace(encodeOctahedral(glm::vec3(front)));
  }

  /// Of a triangle that was dropped. Few are, so that their places are looked up one by one.
  bool isLost(const PackedInput::FaceBlock& block, glm::u32vec3 corners) const {
    const glm::u32vec3 t(block.corners[corners.x], block.corners[corners.y], block.corners[corners.z]);
    if (t.x == t.y || t.y == t.z || t.z == t.x) return false;
    const glm::dvec3 a = input_.positionOf(t.x), b = input_.positionOf(t.y), c = input_.positionOf(t.z);
    return a != b && b != c && c != a;
  }

  void giveOut(const PackedInput::FaceBlock& block, const Face& face, glm::u32vec3 corners,
               DereferenceCounts& counts, const SoupSink& sink) {
    SoupTriangle triangle;
    for (int k = 0; k < 3; ++k) {
      const uint64_t rank = faces_.rank(block.corners[corners[k]]);
      triangle.corners[k] = positions_[rank];
      VertexAttributes& attributes = triangle.attributes[k];
      if (!attributes_.empty()) attributes = attributes_[rank];
      if (!block.texture.empty()) attributes.texture = block.texture[corners[k]];
      if (attributes.normal == kNoNormal) attributes.normal = normalOf(block, face);
      attributes.material = face.material;
    }
    if (triangle.corners[0] == triangle.corners[1] || triangle.corners[1] == triangle.corners[2] ||
        triangle.corners[2] == triangle.corners[0]) {
      ++counts.dropped;
      counts.lost += isLost(block, corners);
      return;
    }
    ++counts.triangles;
    sink(triangle);
  }

  const PackedInput& input_;
  const Lattice& lattice_;
  FaceBatch faces_;
  std::vector<PositionCode> positions_;
  std::vector<VertexAttributes> attributes_;
  std::vector<glm::dvec3> outline_;
  std::vector<glm::u32vec3> cut_;
  std::optional<uint16_t> normal_of_face_;  ///< of the one that is given out
};

}  // namespace

DereferenceCounts dereference(const PackedInput& input, const Lattice& lattice, uint64_t memory_bytes,
                              const SoupSink& sink, const BuildProgress& progress,
                              const DereferencePoint& from, const BatchSink& on_batch) {
  DereferenceCounts counts = from.counts;
  PackedInput::FaceCursor cursor(input, from.face_offset);
  Batch batch(input, lattice, memory_bytes / 2);
  uint64_t faces = from.faces, begin = cursor.offset();
  for (; batch.readFaces(cursor); begin = cursor.offset()) {
    if (on_batch) on_batch({begin, faces, counts});
    batch.sweepVertices(counts);
    for (const PackedInput::FaceBlock& block : batch.blocks()) {
      batch.giveOut(block, counts, sink);
      faces += block.faceCount();
      if (progress) {
        progress("dereference", static_cast<double>(faces) / static_cast<double>(input.faceCount()), faces,
                 input.faceCount());
      }
    }
  }
  return counts;
}

}  // namespace lode::ingest
