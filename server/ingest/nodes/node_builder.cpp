#include "server/ingest/nodes/node_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "common/codec/draco_codec.h"
#include "common/release_storage.h"
#include "server/ingest/measure/boundary_gap.h"
#include "server/ingest/measure/lod_deviation.h"
#include "server/ingest/measure/lost_detail.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/nodes/computed_normals.h"
#include "server/ingest/nodes/lod_targets.h"
#include "server/ingest/plan/machine.h"
#include "server/ingest/simplify/cluster.h"
#include "server/ingest/threads/in_order.h"

namespace lode::ingest {
namespace {

/// A node has at most kReferencesPerTriangle * triangles_per_node references (see ReferenceBoundary).
constexpr size_t kReferencesPerTriangle = 2;
/// A node passes up to triangles_per_node / kTrianglesPerSample samples to its parent, or more in a small
/// node; see the next constants.
constexpr uint32_t kTrianglesPerSample = 2;
/// Smallest limit for the number of samples: kSamplesPerTriangle * triangles_per_node, but at most
/// kSamplesOfSmallNode.
constexpr uint32_t kSamplesOfSmallNode = 8192, kSamplesPerTriangle = 16;

}  // namespace

FinishedLod finishLod(SimplifiedMesh&& simplified, const LodInput& input,
                      std::span<const SurfaceSample> samples, double step_model, const CreaseAngle& crease,
                      MeshSource source) {
  FinishedLod finished;
  finished.simplified = std::move(simplified);
  SimplifiedMesh& lod = finished.simplified;
  const std::vector<uint32_t> sources = sourcesOf(lod, input.mesh());
  const LodSurface surface(lod.mesh);
  const std::vector<SurfaceWalk::Place> places = placesOn(lod, input.mesh(), surface.walk());
  giveComputedNormals(lod, input.mesh(), sources, places, crease);
  finished.payload = encodePayload(toMesh(lod.mesh), step_model, source);
  if (lod.mesh.triangles.empty()) return finished;
  finished.deviations = deviationsFrom(lod, input.mesh(), surface, places, samples);
  float sampled = 0;
  for (const Deviation& deviation : finished.deviations) sampled = std::max(sampled, deviation.steps);
  const LodDeviation deviation = lodDeviation(lod, input, {surface, places, sources}, sampled);
  finished.deviation_steps = deviation.steps;
  finished.farthest = deviation.farthest;
  if (finished.farthest) finished.farthest->near = lod.remap[finished.farthest->near];
  finished.boundary_gap_steps = boundaryGap(lod, input);
  finished.lost_detail_steps = lostDetail(lod, input.mesh(), places);
  return finished;
}

NodeBuilder::NodeBuilder(const Settings& settings, const Partition& partition, const TemporaryFolder& folder)
    : settings_(settings), partition_(partition), folder_(folder) {}

BuiltNode NodeBuilder::buildLeaf(uint32_t leaf, Room room) {
  BuiltNode built;
  built.node.key = partition_.leaves[leaf];
  NodeMesh mesh = loadLeaf(leaf);
  built.original_triangles = mesh.triangles.size();
  built.references.gap_steps = settings_.snap_error_steps;
  addLod(built, mesh, encodePayload(toMesh(mesh), settings_.lattice.step, MeshSource::kFile),
         {.deviation_steps = settings_.snap_error_steps});
  if (built.node.key == kRootKey) {
    for (uint32_t i = 0; i < mesh.positions.size(); ++i) built.samples.push_back({mesh.positions[i], 0, i});
    const std::vector<SurfaceSample> inside = samplesInside(mesh);
    built.samples.insert(built.samples.end(), inside.begin(), inside.end());
    dropDuplicates(built.samples);
    reduce(built, std::move(mesh), true, room);
  } else {
    built.coarsest = std::move(mesh);
  }
  return built;
}

BuiltNode NodeBuilder::buildInner(NodeKey key, std::span<BuiltNode> children, Room room) {
  BuiltNode built;
  built.node.key = key;
  std::vector<NodeMesh> meshes;
  bool is_original = true;
  for (BuiltNode& child : children) {
    built.node.child_mask |= static_cast<uint8_t>(1u << child.node.key.octant());
    built.node.box.add(child.node.box);
    built.original_triangles += child.original_triangles;
    const LodError error = errorOf(child.node.sourceLod());
    built.inherited.deviation_steps = std::max(built.inherited.deviation_steps, error.deviation_steps);
    built.inherited.lost_detail_steps = std::max(built.inherited.lost_detail_steps, error.lost_detail_steps);
    is_original = is_original && child.node.isLeaf();
    meshes.push_back(std::move(child.coarsest));
  }
  std::vector<std::vector<uint32_t>> remap;
  NodeMesh input = mergeMeshes(meshes, remap);
  gatherSamples(built, children, meshes, input, remap);
  gatherReferences(built, children, remap);
  releaseStorage(meshes);
  releaseStorage(remap);
  if (room.is_tight) built.samples.shrink_to_fit();
  reduce(built, std::move(input), is_original, room);
  selectSamples(built.samples, built.coarsest.positions.size(), sampleCapacity());
  return built;
}

size_t NodeBuilder::sampleCapacity() const noexcept {
  const uint32_t capacity = settings_.triangles_per_node;
  const uint32_t least =
      std::min(kSamplesOfSmallNode, std::min(capacity, kSamplesOfSmallNode) * kSamplesPerTriangle);
  return std::max(least, capacity / kTrianglesPerSample);
}

void NodeBuilder::gatherSamples(BuiltNode& built, std::span<BuiltNode> children,
                                std::span<const NodeMesh> meshes, const NodeMesh& input,
                                std::span<const std::vector<uint32_t>> remap) {
  std::vector<SurfaceSample> of_leaves;
  std::vector<bool> taken(input.positions.size());
  for (size_t i = 0; i < children.size(); ++i) {
    if (children[i].node.isLeaf()) {
      for (const uint32_t position : remap[i]) {
        if (!taken[position]) of_leaves.push_back({input.positions[position], 0, position});
        taken[position] = true;
      }
      children[i].samples = samplesInside(meshes[i]);
    } else {
      addLockedPositions(children[i].samples, meshes[i], children[i].node.key.depth());
    }
    for (SurfaceSample& sample : children[i].samples)
      if (sample.near != kVanished) sample.near = remap[i][sample.near];
    std::vector<SurfaceSample>& samples = children[i].node.isLeaf() ? of_leaves : built.samples;
    samples.insert(samples.end(), children[i].samples.begin(), children[i].samples.end());
    releaseStorage(children[i].samples);
  }
  dropDuplicates(built.samples);
  built.samples.insert(built.samples.end(), of_leaves.begin(), of_leaves.end());
}

void NodeBuilder::gatherReferences(BuiltNode& built, std::span<BuiltNode> children,
                                   std::span<const std::vector<uint32_t>> remap) {
  ReferenceBoundaries& all = built.references;
  for (size_t i = 0; i < children.size(); ++i) {
    ReferenceBoundaries& references = children[i].references;
    for (ReferenceBoundary& boundary : references.boundaries)
      boundary.near = imageOf(boundary.near, remap[i]);
    all.boundaries.insert(all.boundaries.end(), references.boundaries.begin(), references.boundaries.end());
    all.gap_steps = std::max(all.gap_steps, references.gap_steps);
    releaseStorage(references.boundaries);
  }
}

void NodeBuilder::simplify(NodeMesh mesh, int depth, std::span<const size_t> targets,
                           const SnapshotSink& sink) const {
  const CollapseOptions options{.node_depth = depth, .max_position = settings_.extent};
  const bool is_cluster = settings_.simplifier == Simplifier::kCluster;
  (is_cluster ? cluster : collapse)(withoutSmoothNormals(std::move(mesh)), targets, options, sink);
}

/// Simplifies a node to all its LODs and stores them on disk, to be measured later. @return the input mesh,
/// followed by the LODs.
LodSpool NodeBuilder::spoolLods(NodeMesh mesh, NodeKey key, std::span<const size_t> targets) const {
  LodSpool lods_on_disk(folder_.file("lods-" + std::to_string(key.value)));
  SimplifiedMesh input{std::move(mesh), {}};
  lods_on_disk.put(input);
  trimHeap();
  simplify(std::move(input.mesh), key.depth(), targets,
           [&](size_t, SimplifiedMesh&& lod) { lods_on_disk.put(lod); });
  trimHeap();
  return lods_on_disk;
}

/// Adds a node's reduced LODs, all from one sequence of collapses.
/// @param is_original  true if the mesh consists of original triangles.
void NodeBuilder::reduce(BuiltNode& built, NodeMesh mesh, bool is_original, Room room) {
  const int depth = built.node.key.depth();
  const auto locked = static_cast<size_t>(
      std::count_if(mesh.lca_depth.begin(), mesh.lca_depth.end(), [&](uint8_t lca) { return lca < depth; }));
  const LodRule rule{.depth = depth,
                     .is_leaf = built.node.isLeaf(),
                     .locked = locked,
                     .original_triangles = built.original_triangles,
                     .triangles_per_node = settings_.triangles_per_node};
  const std::vector<size_t> targets = lodTargets(mesh.triangles.size(), rule);
  if (targets.empty()) {
    built.coarsest = std::move(mesh);
    return;
  }
  std::optional<LodSpool> lods_on_disk;
  if (room.is_tight) {
    lods_on_disk.emplace(spoolLods(std::move(mesh), built.node.key, targets));
    mesh = lods_on_disk->read(0).mesh;
  }
  const auto off_steps = is_original ? std::nullopt : std::optional(built.inherited.deviation_steps);
  const LodInput input(std::move(mesh), depth, off_steps, std::move(built.references));
  FinishedLod coarsest;
  InOrder<FinishedLod> lods(room.helpers, [&](FinishedLod&& lod) {
    if (built.node.lods.empty() || lod.simplified.mesh.triangles.size() < built.node.lods.back().triangles)
      addLod(built, lod);
    releaseStorage(lod.payload.bytes);
    coarsest = std::move(lod);
  });
  const auto finish = [&](SimplifiedMesh&& lod) {
    lods.push([&, lod = std::move(lod)]() mutable {
      return finishLod(std::move(lod), input, built.samples, settings_.lattice.step, settings_.crease,
                       MeshSource::kSimplified);
    });
  };
  if (lods_on_disk) {
    for (size_t i = 1; i < lods_on_disk->size(); ++i) {
      finish(lods_on_disk->read(i));
      trimHeap();
    }
  } else {
    simplify(input.mesh(), depth, targets, [&](size_t, SimplifiedMesh&& lod) { finish(std::move(lod)); });
  }
  lods.finish();
  const std::vector<Deviation>& deviations = coarsest.deviations;
  for (size_t i = 0; i < built.samples.size(); ++i) {
    SurfaceSample& sample = built.samples[i];
    sample.near = deviations.empty() ? kVanished : deviations[i].near;
    if (!deviations.empty()) sample.deviation = deviations[i].steps;
  }
  if (coarsest.farthest) built.samples.push_back(*coarsest.farthest);
  built.references = referencesIn(input, coarsest.simplified.remap, coarsest.boundary_gap_steps,
                                  kReferencesPerTriangle * settings_.triangles_per_node);
  built.coarsest = std::move(coarsest.simplified.mesh);
  addFarLods(built, farLodTargets(built.coarsest.triangles.size(), rule));
}

/// Adds far LODs, simplified from the coarsest LOD, which remains the input of the parent. Measures far LODs
/// against the coarsest LOD, as the parent's LODs are measured against the parent's input.
void NodeBuilder::addFarLods(BuiltNode& built, std::span<const size_t> targets) {
  if (targets.empty()) return;
  const int depth = built.node.key.depth();
  const LodInput input(built.coarsest, depth, errorOf(built.node.lods.back()).deviation_steps,
                       built.references);
  simplify(input.mesh(), depth, targets, [&](size_t, SimplifiedMesh&& simplified) {
    if (simplified.mesh.triangles.size() >= built.node.lods.back().triangles) return;
    FinishedLod lod = finishLod(std::move(simplified), input, built.samples, settings_.lattice.step,
                                settings_.crease, MeshSource::kFarLod);
    addLod(built, lod);
    ++built.node.far_lods;
  });
}

/// Moves the payload out of `lod`.
void NodeBuilder::addLod(BuiltNode& built, FinishedLod& lod) {
  addLod(built, lod.simplified.mesh, std::move(lod.payload), errorOf(built, lod));
}

LodError NodeBuilder::errorOf(const BuiltNode& built, const FinishedLod& lod) const {
  const LodError finer = built.node.lods.empty() ? built.inherited : errorOf(built.node.lods.back());
  if (lod.simplified.mesh.triangles.empty()) {
    const float all = glm::length(glm::vec3(built.node.box.max - built.node.box.min));
    return {std::max(finer.deviation_steps, all), finer.lost_detail_steps};
  }
  const float both = std::hypot(lod.deviation_steps, settings_.snap_error_steps);
  return {std::max({finer.deviation_steps, both, lod.boundary_gap_steps}),
          std::max(finer.lost_detail_steps, lod.lost_detail_steps)};
}

LodError NodeBuilder::errorOf(const Lod& lod) const noexcept {
  // Round up, so that the error does not shrink when it is converted back to model units. Otherwise a
  // parent's error could be smaller than its child's, which violates I3 of docs/architecture.md.
  const auto inSteps = [&](float model) {
    const auto steps = static_cast<float>(model / settings_.lattice.step);
    const bool is_less = static_cast<float>(steps * settings_.lattice.step) < model;
    return is_less ? std::nextafter(steps, std::numeric_limits<float>::infinity()) : steps;
  };
  return {inSteps(lod.error_model), inSteps(lod.appearance_error_model)};
}

void NodeBuilder::addLod(BuiltNode& built, const NodeMesh& mesh, EncodedPayload&& payload, LodError error) {
  built.payloads.push_back(std::move(payload.bytes));
  const int depth = built.node.key.depth();
  Lod lod;
  lod.triangles = static_cast<uint32_t>(mesh.triangles.size());
  lod.vertices = payload.vertices;
  lod.locked = static_cast<uint32_t>(
      std::count_if(mesh.lca_depth.begin(), mesh.lca_depth.end(), [&](uint8_t lca) { return lca < depth; }));
  lod.error_model = static_cast<float>(error.deviation_steps * settings_.lattice.step);
  lod.appearance_error_model = static_cast<float>(error.lost_detail_steps * settings_.lattice.step);
  built.node.lods.push_back(lod);
  for (const PositionCode position : mesh.positions) built.node.box.add(unpackPosition(position));
}

NodeMesh NodeBuilder::loadLeaf(uint32_t leaf) {
  NodeMesh mesh = partition_.readLeaf(leaf);
  mesh.attributes = settings_.attributes;
  const std::vector<BorderVertex> border = partition_.border.read(leaf);
  for (size_t p = 0; p < mesh.positions.size() && !border.empty(); ++p) {
    const std::span<const BorderVertex> shared = sharedAt(border, mesh.positions[p]);
    if (!shared.empty()) mesh.lca_depth[p] = shared.front().lca_depth;
  }
  if (settings_.attributes.has(AttributeSet::kComputedNormal))
    giveLeafNormals(mesh, border, settings_.crease);
  return mesh;
}

}  // namespace lode::ingest
