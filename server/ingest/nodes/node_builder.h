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
#include "server/ingest/nodes/node_spool.h"
#include "server/ingest/partition/normal_fans.h"
#include "server/ingest/partition/partition.h"
#include "server/ingest/plan/simplifier.h"
#include "server/ingest/simplify/collapse.h"
#include "server/ingest/threads/helpers.h"

namespace lode::ingest {

/// An LOD, encoded and measured against what it was made of, and its boundaries against the original's;
/// lengths are in lattice steps.
struct FinishedLod {
  SimplifiedMesh simplified;
  EncodedPayload payload;
  std::vector<Deviation> deviations;      ///< of the samples; see deviationsFrom()
  float deviation_steps = 0;              ///< see lodDeviation()
  std::optional<SurfaceSample> farthest;  ///< see LodDeviation, but near a position of the LOD
  float boundary_gap_steps = 0;           ///< see boundaryGap()
  float lost_detail_steps = 0;            ///< see lostDetail()
};

/// Gives a simplified mesh its computed normals, where they are not the file's, measures and encodes it.
/// @param samples  near positions of the input. @param step_model  the lattice's. Thread safe.
FinishedLod finishLod(SimplifiedMesh&& simplified, const LodInput& input,
                      std::span<const SurfaceSample> samples, double step_model, const CreaseAngle& crease,
                      MeshSource source);

/// What an LOD is off by, in lattice steps.
struct LodError {
  float deviation_steps = 0;
  float lost_detail_steps = 0;  ///< see lostDetail()
};

/// A node with all its LODs, and what its parent needs of it.
struct BuiltNode {
  Node node;                                  ///< payloads not numbered yet
  std::vector<PayloadSpool::Place> payloads;  ///< one an LOD
  NodeMesh coarsest;                          ///< but for far LODs: what the parent is made of
  uint64_t original_triangles = 0;            ///< in the leaves below
  LodError inherited;                         ///< the largest of the children's source LODs
  ReferenceBoundaries references;             ///< near positions of `coarsest`
  std::vector<SurfaceSample>
      samples;  ///< near positions of `coarsest`; a leaf has none: its vertices are them
};

/// Stage 4 for one node. One builder a thread; what it shares is thread safe.
class NodeBuilder {
 public:
  struct Settings {
    Lattice lattice;
    glm::uvec3 extent{0};
    AttributeSet attributes;  ///< of payloads: the file's, and computed normals where it has none
    uint32_t triangles_per_node = 0;
    Simplifier simplifier = Simplifier::kCollapse;
    float snap_error_steps = 0;  ///< of the leaves' vertices
    CreaseAngle crease{180};
  };
  /// What a node may take.
  struct Room {
    Helpers& helpers;       ///< finish LODs beside the builder
    bool is_tight = false;  ///< the node is large: LODs wait on the disk until all are made
  };
  /// @param folder  for LODs that wait.
  NodeBuilder(const Settings& settings, const Partition& partition, PayloadSpool& payloads,
              const TemporaryFolder& folder);

  BuiltNode buildLeaf(uint32_t leaf, Room room);
  /// @param children  non-empty, in octant order; what is needed of them is used up.
  BuiltNode buildInner(NodeKey key, std::span<BuiltNode> children, Room room);

 private:
  NodeMesh loadLeaf(uint32_t leaf);
  size_t sampleCapacity() const noexcept;
  /// Fills in samples that lie near positions of `input`, the union of the children's meshes.
  static void gatherSamples(BuiltNode& built, std::span<BuiltNode> children, std::span<const NodeMesh> meshes,
                            const NodeMesh& input, std::span<const std::vector<uint32_t>> remap);
  /// Fills in references for the same input.
  static void gatherReferences(BuiltNode& built, std::span<BuiltNode> children,
                               std::span<const std::vector<uint32_t>> remap);
  void addFarLods(BuiltNode& built, std::span<const size_t> targets);
  void reduce(BuiltNode& built, NodeMesh mesh, bool is_original, Room room);
  void simplify(NodeMesh mesh, int depth, std::span<const size_t> targets, const SnapshotSink& sink) const;
  LodSpool spoolLods(NodeMesh mesh, NodeKey key, std::span<const size_t> targets) const;
  void addLod(BuiltNode& built, const FinishedLod& lod);
  void addLod(BuiltNode& built, const NodeMesh& mesh, const EncodedPayload& payload, LodError error);
  /// Error of an LOD in lattice steps: its deviation, and by what the lattice has moved vertices as an
  /// independent one; not below the gap of its boundaries, which I2 bounds strictly, nor the finer LOD's
  /// error (I3).
  LodError errorOf(const BuiltNode& built, const FinishedLod& lod) const;
  LodError errorOf(const Lod& lod) const noexcept;

  const Settings settings_;
  const Partition& partition_;
  PayloadSpool& payloads_;
  const TemporaryFolder& folder_;
};

}  // namespace lode::ingest
