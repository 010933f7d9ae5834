#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/codec/draco_codec.h"
#include "common/codec/hierarchy_page.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/disk/temporary_folder.h"
#include "server/ingest/measure/lod_input.h"
#include "server/ingest/measure/surface_samples.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/nodes/lod_spool.h"
#include "server/ingest/partition/normal_fans.h"
#include "server/ingest/partition/partition.h"
#include "server/ingest/plan/build_options.h"
#include "server/ingest/simplify/collapse.h"
#include "server/ingest/threads/helpers.h"

namespace lode::ingest {

/// An LOD with its payload, its errors, and the gap between its boundaries and the boundaries of the
/// original. Lengths are in lattice steps.
struct FinishedLod {
  SimplifiedMesh simplified;
  EncodedPayload payload;
  std::vector<Deviation> deviations;  ///< one deviation per sample; see deviationsFrom()
  float deviation_steps = 0;          ///< deviation from the original; see lodDeviation()
  /// Farthest point of the original, as in LodDeviation, but `near` is a position of the LOD.
  std::optional<SurfaceSample> farthest;
  /// Gap between the boundaries of the LOD and of the original; see boundaryGap().
  float boundary_gap_steps = 0;
  float lost_detail_steps = 0;  ///< size of lost detail; see lostDetail()
};

/// Measures and encodes a simplified mesh, after computing its normals unless they come from the file. Thread
/// safe.
/// @param samples  samples whose `near` are positions of the input. @param step_model  length of a lattice
/// step in model units.
FinishedLod finishLod(SimplifiedMesh&& simplified, const LodInput& input,
                      std::span<const SurfaceSample> samples, double step_model, const CreaseAngle& crease,
                      MeshSource source);

/// Errors of an LOD, in lattice steps.
struct LodError {
  float deviation_steps = 0;
  float lost_detail_steps = 0;  ///< size of lost detail; see lostDetail()
};

/// A node with all its LODs, and the data that its parent needs.
struct BuiltNode {
  Node node;                                     ///< the node; its payloads have no blob numbers yet
  std::vector<std::vector<std::byte>> payloads;  ///< encoded payload of each LOD, until a file stores it
  NodeMesh coarsest;                ///< mesh of the coarsest LOD except far LODs; part of the parent's input
  uint64_t original_triangles = 0;  ///< number of triangles in the leaves below
  LodError inherited;               ///< largest error of the children's LODs that form this node's input
  ReferenceBoundaries references;   ///< each one's `near` is a position of `coarsest`
  /// Samples; each one's `near` is a position of `coarsest`. Empty in a leaf, whose vertices serve as
  /// samples.
  std::vector<SurfaceSample> samples;
};

/// Builds single nodes: simplifies, measures and encodes. Use one builder per thread; the data that builders
/// share is thread safe.
class NodeBuilder {
 public:
  struct Settings {
    Lattice lattice;
    glm::uvec3 extent{0};
    /// Attributes in payloads: the attributes of the file, and computed normals if the file has no normals.
    AttributeSet attributes;
    uint32_t triangles_per_node = 0;
    Simplifier simplifier = Simplifier::kCollapse;
    float snap_error_steps = 0;  ///< largest distance by which rounding to the lattice moved a vertex
    CreaseAngle crease{180};
  };
  /// Resources for building a node.
  struct Room {
    Helpers& helpers;  ///< threads that measure and encode LODs besides the builder's own thread
    /// True if the node is large. Its LODs then wait on disk until the last is simplified.
    bool is_tight = false;
  };
  /// @param folder  folder for LODs on disk.
  NodeBuilder(const Settings& settings, const Partition& partition, const TemporaryFolder& folder);

  BuiltNode buildLeaf(uint32_t leaf, Room room);
  /// @param children  children that have triangles, in octant order; the function moves their data out.
  BuiltNode buildInner(NodeKey key, std::span<BuiltNode> children, Room room);

 private:
  NodeMesh loadLeaf(uint32_t leaf);
  size_t sampleCapacity() const noexcept;
  /// Collects the children's samples, mapped to positions of `input`, the union of their meshes.
  static void gatherSamples(BuiltNode& built, std::span<BuiltNode> children, std::span<const NodeMesh> meshes,
                            const NodeMesh& input, std::span<const std::vector<uint32_t>> remap);
  /// Collects the children's references, mapped to positions of the union of the children's meshes.
  static void gatherReferences(BuiltNode& built, std::span<BuiltNode> children,
                               std::span<const std::vector<uint32_t>> remap);
  void addFarLods(BuiltNode& built, std::span<const size_t> targets);
  void reduce(BuiltNode& built, NodeMesh mesh, bool is_original, Room room);
  void simplify(NodeMesh mesh, int depth, std::span<const size_t> targets, const SnapshotSink& sink) const;
  LodSpool spoolLods(NodeMesh mesh, NodeKey key, std::span<const size_t> targets) const;
  void addLod(BuiltNode& built, FinishedLod& lod);
  void addLod(BuiltNode& built, const NodeMesh& mesh, EncodedPayload&& payload, LodError error);
  /// Returns the error of an LOD in lattice steps: the LOD's deviation, combined with the lattice's rounding
  /// as an independent error. The result is never less than the distance of the LOD's boundary edges from
  /// the original ones, nor less than the error of the next finer LOD (I2 and I3 of docs/architecture.md).
  LodError errorOf(const BuiltNode& built, const FinishedLod& lod) const;
  LodError errorOf(const Lod& lod) const noexcept;

  const Settings settings_;
  const Partition& partition_;
  const TemporaryFolder& folder_;
};

}  // namespace lode::ingest
