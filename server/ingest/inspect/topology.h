#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/disk/temporary_folder.h"
#include "server/ingest/inspect/border_gaps.h"
#include "server/ingest/inspect/piece_counter.h"
#include "server/ingest/inspect/same_places.h"
#include "server/ingest/soup/face_batch.h"
#include "server/ingest/soup/lost_triangles.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

constexpr uint64_t kMaxBorderEdges = 1 << 20;  ///< largest number of open edges whose places are kept

/// Topology of a file's faces. As in a build, vertices at exactly the same position count as one vertex,
/// except in the numbers of duplicate and unused vertices.
struct Topology {
  /// Number of vertices at the position of an earlier vertex. Bad vertices, which are skipped, count as being
  /// at the origin.
  uint64_t duplicate_vertices = 0;
  uint64_t unused_vertices = 0;     ///< vertices that no face uses
  uint64_t flat_faces = 0;          ///< faces with fewer than three distinct positions
  uint64_t open_edges = 0;          ///< edges that one face uses
  uint64_t non_manifold_edges = 0;  ///< edges that three or more faces use
  uint64_t misoriented_edges = 0;   ///< edges that two faces use in the same direction
  uint64_t pieces = 0;              ///< connected sets of faces; faces are connected if they share a vertex
  /// Number of faces with a mean vertex normal that points to the back of the face.
  uint64_t opposed_faces = 0;
  /// Triangles that would vanish on the lattice that a build chooses; see LostTriangles.
  uint64_t lost_triangles = 0;
  double lattice_step = 0;  ///< step of the lattice that a build chooses; 0 if there is no suitable lattice
  std::string_view lattice_problem;  ///< reason why there is no suitable lattice, and a remedy
  OpenBorder border;                 ///< the first kMaxBorderEdges open edges
  /// Box of the vertices that faces use; zero if there are none.
  glm::dvec3 used_min{0}, used_max{0};
};

/// Counts topology with sorts and sweeps over temporary files, in bounded memory plus two bits per vertex.
/// Not thread safe. All functions throw Error kIo.
class TopologyCounter {
 public:
  /// @param folder  folder for temporary files.
  /// @param attributes  the file's attributes; only kNormal matters.
  /// @param double_positions  true if floats are not precise enough for the positions.
  /// @param memory_bytes  approximate limit.
  TopologyCounter(const TemporaryFolder& folder, AttributeSet attributes, bool double_positions,
                  uint64_t memory_bytes);

  void addVertices(std::span<const PlyVertex> vertices);
  void addFaces(const PlyFaces& faces);
  /// Counts the topology. Call once, after adding all vertices and faces. @pre at most 2^32 vertices.
  Topology count();

 private:
  /// Vertex data that faces need.
  struct Member {
    glm::dvec3 position;
    uint32_t first;   ///< first vertex at the same position
    uint16_t normal;  ///< octahedral code of the vertex's normal, or kNoNormal
  };

  void countVertices();
  void countFaces();
  void sweep(const FaceBatch& batch);
  void countFace();
  bool isOpposed() const;
  void addEdges();
  void countEdges();
  void placeBorder(std::vector<uint32_t> ends);

  const TemporaryFolder& folder_;
  const bool has_normals_;
  const uint64_t memory_bytes_;
  PackedInput input_;
  SamePlaces places_;
  RecordSorter edges_;  ///< all edges of faces: the key contains both vertices, the record the direction
  std::optional<PieceCounter> pieces_;
  std::optional<VertexSet> used_;            ///< first vertices of the positions that faces use
  std::optional<LostTriangleCounter> lost_;  ///< empty if there is no suitable lattice
  std::vector<Member> members_;              ///< vertices of the current batch
  std::vector<Member> face_;                 ///< corners of the current face
  std::vector<glm::dvec3> corners_;          ///< positions of the current face
  Topology topology_;
};

}  // namespace lode::ingest
