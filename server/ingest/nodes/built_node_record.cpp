#include "server/ingest/nodes/built_node_record.h"

#include <utility>

#include "common/limits.h"

namespace lode::ingest {
namespace {

struct LodRecord {
  uint32_t triangles, vertices, locked;
  float error_model, appearance_error_model;
  uint32_t payload_bytes;
  uint64_t payload_offset;
};

void putMesh(RecordWriter& record, const NodeMesh& mesh) {
  // Name all members, so that this code does not compile after a member is added.
  const auto& [attributes, positions, lca_depth, wedge_position, wedge_attributes, triangles] = mesh;
  record.put(attributes);
  record.putAll(positions);
  record.putAll(lca_depth);
  record.putAll(wedge_position);
  record.putAll(wedge_attributes);
  record.putAll(triangles);
}

NodeMesh getMesh(RecordReader& record) {
  NodeMesh mesh;
  mesh.attributes = record.get<AttributeSet>();
  mesh.positions = record.getAll<PositionCode>();
  mesh.lca_depth = record.getAll<uint8_t>();
  mesh.wedge_position = record.getAll<uint32_t>();
  mesh.wedge_attributes = record.getAll<VertexAttributes>();
  mesh.triangles = record.getAll<glm::u32vec3>();
  return mesh;
}

void requirePosition(uint32_t near, const NodeMesh& mesh) {
  if (near == kVanished || near < mesh.positions.size()) return;
  throw Error(ErrorCode::kFormat, "the build journal refers to a missing position; build without --resume");
}

}  // namespace

void putFinishedNode(RecordWriter& record, const Node& node, std::span<const PayloadPlace> payloads) {
  record.put(node.key);
  record.put(node.box);
  record.put(node.child_mask);
  std::vector<LodRecord> lods;
  for (size_t r = 0; r < node.lods.size(); ++r) {
    const Lod& lod = node.lods[r];
    lods.push_back({lod.triangles, lod.vertices, lod.locked, lod.error_model, lod.appearance_error_model,
                    payloads[r].bytes, payloads[r].offset});
  }
  record.putAll(lods);
  record.put(node.far_lods);
}

FinishedNode getFinishedNode(RecordReader& record) {
  FinishedNode finished;
  finished.node.key = record.get<NodeKey>();
  finished.node.box = record.get<LatticeBox>();
  finished.node.child_mask = record.get<uint8_t>();
  const std::vector<LodRecord> lods = record.getAll<LodRecord>();
  finished.node.far_lods = record.get<uint32_t>();
  finished.node.lods.reserve(lods.size());
  for (const LodRecord& from : lods) {
    Lod lod;
    lod.triangles = from.triangles;
    lod.vertices = from.vertices;
    lod.locked = from.locked;
    lod.error_model = from.error_model;
    lod.appearance_error_model = from.appearance_error_model;
    finished.node.lods.push_back(lod);
    finished.payloads.push_back({from.payload_offset, from.payload_bytes});
  }
  if (finished.node.lods.empty() || finished.node.lods.size() > kMaxLods) {
    throw Error(ErrorCode::kLimit, "the build journal has a node with " +
                                       std::to_string(finished.node.lods.size()) +
                                       " LODs; build without --resume");
  }
  return finished;
}

void putBuiltNode(RecordWriter& record, const BuiltNode& built) {
  const auto& [node, payloads, coarsest, original_triangles, inherited, references, samples] = built;
  putFinishedNode(record, node, std::vector<PayloadPlace>(node.lods.size()));
  putMesh(record, coarsest);
  record.put(original_triangles);
  record.put(inherited);
  record.put(references.gap_steps);
  record.putAll(references.boundaries);
  record.putAll(samples);
}

BuiltNode getBuiltNode(RecordReader& record) {
  BuiltNode built;
  built.node = getFinishedNode(record).node;
  built.coarsest = getMesh(record);
  built.original_triangles = record.get<uint64_t>();
  built.inherited = record.get<LodError>();
  built.references.gap_steps = record.get<float>();
  built.references.boundaries = record.getAll<ReferenceBoundary>();
  built.samples = record.getAll<SurfaceSample>();
  for (const ReferenceBoundary& boundary : built.references.boundaries) {
    requirePosition(boundary.near.x, built.coarsest);
    requirePosition(boundary.near.y, built.coarsest);
  }
  return built;
}

}  // namespace lode::ingest
