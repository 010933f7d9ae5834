#include "server/ingest/preview/preview.h"

#include <utility>

#include "common/codec/draco_codec.h"
#include "server/ingest/preview/cell_sums.h"
#include "server/ingest/preview/clustered_mesh.h"
#include "server/store/writer.h"

namespace lode::ingest {
namespace {

/// Memory for the cells, for the mesh and for its encoding, whose sizes ClusterLimits bounds.
constexpr uint64_t kMeshBytes = 256u << 20;

}  // namespace

uint64_t previewBytes(const PackedInput& input) noexcept {
  const bool is_textured = input.ofVertices().has(AttributeSet::kTexture);
  const uint64_t texture_bytes = is_textured ? CellSums::kTexturedVertexBytes : 0;
  return input.vertexCount() * (ClusterGrid::kVertexBytes + texture_bytes) + kMeshBytes;
}

bool writePreview(const std::filesystem::path& path, const PackedInput& input, const LatticeChoice& choice,
                  const TextureColours& textures) {
  const ClusteredMesh clustered = clusterInput(input, choice.lattice, choice.extent, textures);
  const Mesh& mesh = clustered.mesh;
  if (mesh.triangles.empty()) return false;
  const EncodedPayload payload = encodePayload(mesh, choice.lattice.step);
  store::Writer writer(path);
  Node root;
  for (const PositionCode position : mesh.positions) root.box.add(unpackPosition(position));
  Lod lod;
  lod.payload = writer.addBlob(payload.bytes);
  lod.triangles = static_cast<uint32_t>(mesh.triangles.size());
  lod.vertices = payload.vertices;
  lod.error_model = lod.appearance_error_model =
      static_cast<float>(clustered.errorSteps() * choice.lattice.step);
  root.lods.push_back(lod);
  ModelSummary summary;
  summary.lattice = choice.lattice;
  summary.attributes = mesh.attributes;
  summary.triangles_per_node = lod.triangles;
  writer.finish(std::move(summary), {std::move(root)});
  return true;
}

}  // namespace lode::ingest
