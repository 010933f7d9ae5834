#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/disk/temporary_folder.h"
#include "server/ingest/inspect/piece_counter.h"
#include "server/ingest/inspect/same_places.h"
#include "server/ingest/soup/face_batch.h"
#include "server/ingest/soup/lost_triangles.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

/// How the faces of a file hang together. All but duplicate and unused vertices is counted after vertices at
/// exactly the same place are taken as one, as a build does.
struct Topology {
  uint64_t duplicate_vertices = 0;   ///< at the place of an earlier one; vertices that were skipped are at 0
  uint64_t unused_vertices = 0;      ///< in no face
  uint64_t flat_faces = 0;           ///< fewer than three distinct places
  uint64_t open_edges = 0;           ///< of one face
  uint64_t non_manifold_edges = 0;   ///< of three or more
  uint64_t misoriented_edges = 0;    ///< of two faces that run along it in the same direction
  uint64_t pieces = 0;               ///< of faces joined by vertices
  uint64_t opposed_faces = 0;        ///< whose vertices' normals, in the mean, point to their back
  uint64_t lost_triangles = 0;       ///< see LostTriangles, on the lattice that a build chooses
  double lattice_step = 0;           ///< of that; zero if there is none
  std::string_view lattice_problem;  ///< why there is none, and what to do
  glm::dvec3 used_min{0}, used_max{0};  ///< box of the vertices that faces use; zero if there are none
};

/// Counts topology by sorts and sweeps over temporary files: in memory stay parts of a bounded size, and two
/// bits a vertex. For one thread. All functions throw Error kIo.
class TopologyCounter {
 public:
  /// @param folder  for temporary files. @param attributes  the file's: of them only normals count.
  /// @param double_positions  positions need more than float. @param memory_bytes  about as much is used.
  TopologyCounter(const TemporaryFolder& folder, AttributeSet attributes, bool double_positions,
                  uint64_t memory_bytes);

  void addVertices(std::span<const PlyVertex> vertices);
  void addFaces(const PlyFaces& faces);
  /// Once, after all vertices and faces. @pre no more than 2^32 vertices.
  Topology count();

 private:
  /// What faces need of a vertex.
  struct Member {
    glm::dvec3 position;
    uint32_t first;   ///< vertex at its place
    uint16_t normal;  ///< octahedral, or kNoNormal
  };

  void countVertices();
  void countFaces();
  void sweep(const FaceBatch& batch);
  void countFace();
  bool isOpposed() const;
  void addEdges();
  void countEdges();

  const TemporaryFolder& folder_;
  const bool has_normals_;
  const uint64_t memory_bytes_;
  PackedInput input_;
  SamePlaces places_;
  RecordSorter edges_;  ///< by both ends; the record is the direction
  std::optional<PieceCounter> pieces_;
  std::optional<VertexSet> used_;            ///< places that faces have, by their first vertex
  std::optional<LostTriangleCounter> lost_;  ///< nothing if there is no lattice
  std::vector<Member> members_;              ///< of the batch at hand
  std::vector<Member> face_;                 ///< at hand: its corners
  std::vector<glm::dvec3> corners_;          ///< of the face at hand
  Topology topology_;
};

}  // namespace lode::ingest
