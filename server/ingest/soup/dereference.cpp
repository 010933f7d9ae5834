#include "server/ingest/soup/dereference.h"

#include <algorithm>
#include <optional>

#include "common/codec/octahedral.h"
#include "server/ingest/soup/face_batch.h"
#include "server/ingest/soup/triangulate.h"
#include "server/ingest/threads/in_order.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kVerticesAPiece = 16 * FaceBatch::kSweepVertices;
/// Divisors of the memory: a batch of faces gets 1/2, the triangles of helper threads get 1/4.
constexpr uint64_t kShareOfFaces = 2, kShareOfHelpers = 4;
constexpr uint64_t kCursorBytes = 1 << 20;  ///< size of a thread's read buffer

/// Vertices that a batch of faces uses, indexed by FaceBatch::rank().
struct BatchVertices {
  std::vector<PositionCode> positions;
  std::vector<VertexAttributes> attributes;  ///< empty if the input's vertices have no attributes
};

/// Snaps the vertices of a batch. @return largest distance that a vertex moves, in lattice steps.
double sweepVertices(const PackedInput& input, const FaceBatch& faces, const Lattice& lattice,
                     Helpers& helpers, BatchVertices& vertices) {
  vertices.positions.resize(faces.members());
  if (input.hasVertexAttributes()) vertices.attributes.resize(faces.members());
  const auto sweep = [&](uint32_t begin, uint64_t end) {
    double error_steps = 0;
    uint32_t rank = faces.rank(begin);
    faces.sweep(begin, end, [&](uint64_t, glm::dvec3 position, const VertexAttributes& attributes) {
      const glm::uvec3 snapped = lattice.snap(position);
      vertices.positions[rank] = packPosition(snapped);
      error_steps = std::max(error_steps, glm::distance(position, lattice.toWorld(snapped)) / lattice.step);
      if (!vertices.attributes.empty()) vertices.attributes[rank] = attributes;
      ++rank;
    });
    return error_steps;
  };
  double farthest_steps = 0;
  InOrder<double> pieces(helpers, [&](double&& steps) { farthest_steps = std::max(farthest_steps, steps); });
  for (uint64_t begin = 0; begin < input.vertexCount(); begin += kVerticesAPiece) {
    const uint64_t end = std::min(begin + kVerticesAPiece, input.vertexCount());
    pieces.push([&sweep, begin, end] { return sweep(static_cast<uint32_t>(begin), end); });
  }
  pieces.finish();
  return farthest_steps;
}

/// The triangles of one block of faces.
struct BlockSoup {
  std::vector<SoupTriangle> triangles;
  uint64_t faces = 0, dropped = 0, lost = 0;  ///< see DereferenceCounts
};

uint64_t mostTriangles(const PackedInput::FaceBlock& block) {
  return block.corners.size() - 2 * block.faceCount();
}

/// Returns how many threads the memory allows in addition to the caller.
unsigned helpersFor(const FaceBatch& faces, unsigned threads, uint64_t memory_bytes) {
  uint64_t triangles = 0;
  for (const PackedInput::FaceBlock& block : faces.blocks())
    triangles = std::max(triangles, mostTriangles(block));
  const uint64_t each =
      (1 + InOrder<BlockSoup>::kWaitingPerThread) * triangles * sizeof(SoupTriangle) + kCursorBytes;
  return static_cast<unsigned>(std::min<uint64_t>(threads - 1, memory_bytes / kShareOfHelpers / each));
}

/// Creates the triangles of one block. Not thread safe.
class BlockDereference {
 public:
  BlockDereference(const PackedInput& input, const FaceBatch& faces, const BatchVertices& vertices,
                   const PackedInput::FaceBlock& block)
      : input_(input), faces_(faces), vertices_(vertices), block_(block) {}

  BlockSoup run() {
    soup_.faces = block_.faceCount();
    soup_.triangles.reserve(mostTriangles(block_));
    size_t number = 0;
    forEachFace(block_, [&](size_t first, uint32_t corners) {
      const uint16_t material = block_.materials.empty() ? uint16_t{0} : block_.materials[number];
      const glm::u8vec4* const colour = block_.colours.empty() ? nullptr : &block_.colours[number];
      add(Face{static_cast<uint32_t>(first), corners, material, colour});
      ++number;
    });
    return std::move(soup_);
  }

 private:
  struct Face {
    uint32_t first, corners;  ///< index of the first corner in the block, and number of corners
    uint16_t material;
    const glm::u8vec4* colour;  ///< null if faces have no colours
  };

  glm::dvec3 positionOf(uint32_t corner) const {
    return unpackPosition(vertices_.positions[faces_.rank(block_.corners[corner])]);
  }

  void add(const Face& face) {
    normal_of_face_.reset();
    if (face.corners == 3) {
      add(face, face.first + glm::u32vec3(0, 1, 2));
      return;
    }
    outline_.clear();
    for (uint32_t c = 0; c < face.corners; ++c) outline_.push_back(positionOf(face.first + c));
    triangulate(outline_, cut_);
    for (const glm::u32vec3& t : cut_) add(face, face.first + t);
  }

  /// Returns the code of the face's normal. Caches the code, because each corner without a normal needs it.
  uint16_t normalOf(const Face& face) {
    if (normal_of_face_) return *normal_of_face_;
    const glm::dvec3 from = positionOf(face.first);
    glm::dvec3 front(0);
    for (uint32_t c = 2; c < face.corners; ++c)
      front += glm::cross(positionOf(face.first + c - 1) - from, positionOf(face.first + c) - from);
    return normal_of_face_.emplace(encodeOctahedral(glm::vec3(front)));
  }

  /// Returns true if a dropped triangle has distinct corners in the file. Reads the positions from disk; this
  /// is rarely needed, because few triangles are dropped.
  bool isLost(glm::u32vec3 corners) const {
    const glm::u32vec3 t(block_.corners[corners.x], block_.corners[corners.y], block_.corners[corners.z]);
    if (t.x == t.y || t.y == t.z || t.z == t.x) return false;
    const glm::dvec3 a = input_.positionOf(t.x), b = input_.positionOf(t.y), c = input_.positionOf(t.z);
    return a != b && b != c && c != a;
  }

  void add(const Face& face, glm::u32vec3 corners) {
    SoupTriangle triangle;
    for (int k = 0; k < 3; ++k) {
      const uint32_t rank = faces_.rank(block_.corners[corners[k]]);
      triangle.corners[k] = vertices_.positions[rank];
      VertexAttributes& attributes = triangle.attributes[k];
      if (!vertices_.attributes.empty()) attributes = vertices_.attributes[rank];
      if (!block_.texture.empty()) attributes.texture = block_.texture[corners[k]];
      if (attributes.normal == kNoNormal) attributes.normal = normalOf(face);
      attributes.material = face.material;
      if (face.colour != nullptr) attributes.colour = *face.colour;
    }
    if (triangle.corners[0] == triangle.corners[1] || triangle.corners[1] == triangle.corners[2] ||
        triangle.corners[2] == triangle.corners[0]) {
      ++soup_.dropped;
      soup_.lost += isLost(corners);
      return;
    }
    soup_.triangles.push_back(triangle);
  }

  const PackedInput& input_;
  const FaceBatch& faces_;
  const BatchVertices& vertices_;
  const PackedInput::FaceBlock& block_;
  BlockSoup soup_;
  std::vector<glm::dvec3> outline_;
  std::vector<glm::u32vec3> cut_;
  std::optional<uint16_t> normal_of_face_;  ///< code of the current face's normal, once computed
};

}  // namespace

DereferenceCounts dereference(const DereferenceInput& in, const SoupSink& sink) {
  const PackedInput& input = in.input;
  DereferenceCounts counts = in.from.counts;
  PackedInput::FaceCursor cursor(input, in.from.face_offset);
  FaceBatch batch(input, in.memory_bytes / kShareOfFaces,
                  sizeof(PositionCode) + (input.hasVertexAttributes() ? sizeof(VertexAttributes) : 0));
  BatchVertices vertices;
  uint64_t faces = in.from.faces, begin = cursor.offset();
  for (; batch.read(cursor); begin = cursor.offset()) {
    if (in.on_batch) in.on_batch({begin, faces, counts});
    FixedHelpers helpers(helpersFor(batch, in.threads, in.memory_bytes));
    counts.snap_error_steps =
        std::max(counts.snap_error_steps, sweepVertices(input, batch, in.lattice, helpers, vertices));
    InOrder<BlockSoup> blocks(helpers, [&](BlockSoup&& soup) {
      counts.triangles += soup.triangles.size();
      counts.dropped += soup.dropped;
      counts.lost += soup.lost;
      faces += soup.faces;
      sink(soup.triangles);
      if (in.progress) {
        in.progress("dereference", static_cast<double>(faces) / static_cast<double>(input.faceCount()), faces,
                    input.faceCount());
      }
    });
    for (const PackedInput::FaceBlock& block : batch.blocks())
      blocks.push([&] { return BlockDereference(input, batch, vertices, block).run(); });
    blocks.finish();
  }
  return counts;
}

}  // namespace lode::ingest
