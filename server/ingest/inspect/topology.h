#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/ply/ply_reader.h"

namespace lode::ingest {

/// How the faces of a file hang together. All but duplicate and unused vertices is counted after vertices at
/// exactly the same place are taken as one, as a build does.
struct Topology {
  uint64_t duplicate_vertices = 0;  ///< at the place of an earlier one; vertices that were skipped are at 0
  uint64_t unused_vertices = 0;     ///< in no face
  uint64_t flat_faces = 0;          ///< fewer than three distinct places
  uint64_t open_edges = 0;          ///< of one face
  uint64_t non_manifold_edges = 0;  ///< of three or more
  uint64_t misoriented_edges = 0;   ///< of two faces that run along it in the same direction
  uint64_t pieces = 0;              ///< of faces joined by vertices
  uint64_t opposed_faces = 0;       ///< whose vertices' normals, in the mean, point to their back
  uint64_t lost_faces = 0;          ///< see isLost(), on the lattice that a build chooses
  double lattice_step = 0;          ///< of that; zero if all vertices coincide
  glm::dvec3 used_min{0}, used_max{0};  ///< box of the vertices that faces use; zero if there are none
};

/// Counts topology in memory, up to a bound. For one thread.
class TopologyCounter {
 public:
  /// @param memory_bytes  when more is needed, everything is let go, and count() gives nothing.
  explicit TopologyCounter(uint64_t memory_bytes) : memory_bytes_(memory_bytes) {}

  /// @param has_normals  the file's
  void addVertices(std::span<const PlyVertex> vertices, bool has_normals);
  void addFaces(const PlyFaces& faces);
  /// Once, after all vertices and faces.
  std::optional<Topology> count();

 private:
  bool fits(uint64_t vertices, uint64_t faces, uint64_t corners);
  void joinVertices();
  void countOpposed();
  void countUsed();
  void countLost();
  void countEdges();
  void countPieces();

  const uint64_t memory_bytes_;
  bool is_too_large_ = false;
  std::vector<glm::dvec3> positions_;
  std::vector<uint16_t> normals_;  ///< octahedral; empty if the file has none
  std::vector<uint32_t> corner_counts_, corners_;
  Topology topology_;
};

}  // namespace lode::ingest
