#include "server/store/verify.h"

#include <algorithm>
#include <string>

#include "common/error.h"
#include "common/image/tile_image.h"
#include "server/store/cut.h"
#include "server/store/export.h"
#include "server/store/open_edges.h"
#include "server/store/reader.h"
#include "server/store/segment_tree.h"

namespace lode::store {
namespace {

constexpr int kPointsPerEdge = 5;  ///< compared points per open edge, including both ends

class Verifier {
 public:
  Verifier(const std::filesystem::path& path, const VerifyOptions& options)
      : options_(options), reader_(path), tree_(reader_.nodes()) {}

  VerifyReport run() {
    report_.bytes = reader_.summary().bytes;
    report_.blobs = reader_.blobCount();
    report_.nodes = reader_.nodes().size();
    checkNames();
    checkTiles();
    checkPayloads();
    checkRandomCuts();
    return report_;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kFormat, reader_.path().string() + ": " + what + "; copy it again or rebuild it");
  }
  [[noreturn]] void fail(const Node& node, size_t lod, const std::string& what) const {
    fail("node " + describeKey(node.key) + ", LOD " + std::to_string(lod) + ": " + what);
  }

  void checkNames() const {
    for (uint32_t number = 1; number <= reader_.blobCount(); ++number)
      if (digestOf(reader_.readBlob(number)) != reader_.blob(number).digest)
        fail("blob " + std::to_string(number) + ": its digest does not match its bytes");
  }

  void checkTiles() {
    for (const Texture& texture : reader_.textures().textures)
      for (uint32_t level = 0; level < levelCount(texture); ++level)
        for (uint32_t y = 0; y < tilesDown(texture, level); ++y)
          for (uint32_t x = 0; x < tilesAcross(texture, level); ++x) checkTile(texture, level, x, y);
  }

  void checkTile(const Texture& texture, uint32_t level, uint32_t x, uint32_t y) {
    const BlobRef& tile = texture.tiles[tileIndex(texture, level, x, y)];
    try {
      decodeTile(reader_.readBlob(tile.number), tileInnerSize(texture, level, x, y) + 2 * kTileGutterPx);
      ++report_.tiles;
    } catch (const Error& error) {
      throw Error(error.code(), reader_.path().string() + ": texture " + texture.name + ", level " +
                                    std::to_string(level) + ", tile " + std::to_string(x) + " " +
                                    std::to_string(y) + ": " + error.what());
    }
  }

  void checkPayloads() {
    for (const Node& node : reader_.nodes())
      for (uint32_t lod = 0; lod < node.lods.size(); ++lod) {
        if (node.lods[lod].triangles == 0) continue;
        const Mesh mesh = readLod(reader_, node, lod);
        checkMesh(node, lod, mesh);
        ++report_.payloads;
        report_.triangles += mesh.triangles.size();
        if (node.isLeaf() && lod == 0) leaf_edges_.add(mesh);
      }
    report_.open_edges = leaf_edges_.edges().size();
  }

  void checkMesh(const Node& node, size_t number, const Mesh& mesh) const {
    const Lod& lod = node.lods[number];
    if (mesh.triangles.size() != lod.triangles) fail(node, number, "its number of triangles does not match");
    if (mesh.positions.size() != lod.vertices) fail(node, number, "its number of vertices does not match");
    LatticeBox box;
    for (const PositionCode position : mesh.positions) box.add(unpackPosition(position));
    if (!node.box.contains(box)) fail(node, number, "a vertex lies outside the node's box");
    for (const glm::u32vec3& t : mesh.triangles) {
      const PositionCode a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
      if (a == b || b == c || c == a) fail(node, number, "a triangle has two corners at one position");
    }
    std::vector<PositionCode> distinct = mesh.positions;
    std::sort(distinct.begin(), distinct.end());
    const auto end = std::unique(distinct.begin(), distinct.end());
    if (lod.locked > static_cast<size_t>(end - distinct.begin()))
      fail(node, number, "more locked vertices than positions");
  }

  void checkRandomCuts() {
    std::vector<Segment> boundaries;
    for (const OpenEdge& edge : leaf_edges_.edges()) boundaries.push_back({toModel(edge.a), toModel(edge.b)});
    const SegmentTree boundary_tree(std::move(boundaries));
    for (unsigned i = 0; i < options_.random_cuts; ++i) {
      const uint64_t seed = options_.seed + i;
      const Cut cut = randomCut(tree_, seed);
      OpenEdges edges;
      for (const CutItem item : cut.items) edges.add(readLod(reader_, tree_.node(item.node), item.lod));
      const std::vector<const Lod*> shown = shownLods(cut);
      for (const OpenEdge& edge : edges.edges()) checkBoundary(edge, boundary_tree, shown, seed);
      ++report_.cuts;
    }
  }

  /// Returns for each node the LOD that a cut contains, or null if the cut does not contain the node.
  std::vector<const Lod*> shownLods(const Cut& cut) const {
    std::vector<const Lod*> shown(tree_.nodes().size());
    for (const CutItem item : cut.items) shown[item.node] = &tree_.node(item.node).lods[item.lod];
    return shown;
  }

  void checkBoundary(const OpenEdge& edge, const SegmentTree& boundaries,
                     const std::vector<const Lod*>& shown, uint64_t seed) {
    const std::string cut = "the random cut " + std::to_string(seed);
    if (boundaries.empty()) fail(cut + " has an open edge where the model is closed (I2)");
    const double allowed = std::max(errorAt(edge.a, shown), errorAt(edge.b, shown));
    const glm::dvec3 from = toModel(edge.a), to = toModel(edge.b);
    for (int i = 0; i < kPointsPerEdge; ++i) {
      const double gap =
          boundaries.distance(glm::mix(from, to, static_cast<double>(i) / (kPointsPerEdge - 1)));
      report_.max_boundary_gap_model = std::max(report_.max_boundary_gap_model, gap);
      if (gap > allowed)
        fail(cut + " has an open edge " + std::to_string(gap) +
             " from the nearest boundary, the error there is " + std::to_string(allowed) + " (I2)");
    }
  }

  /// Returns the largest error of the cut's LODs whose boxes contain a position. The LOD that causes an open
  /// edge need not contain the position itself: if a boundary triangle collapses, the edge of a neighbouring
  /// triangle becomes open.
  double errorAt(PositionCode position, const std::vector<const Lod*>& shown) const {
    LatticeBox point;
    point.add(unpackPosition(position));
    double error = 0;
    std::vector<uint32_t> todo{0};
    while (!todo.empty()) {
      const uint32_t number = todo.back();
      todo.pop_back();
      if (!tree_.node(number).box.contains(point)) continue;
      if (shown[number]) {
        error = std::max<double>(error, shown[number]->error_model);
        continue;
      }
      for (uint32_t i = 0; i < tree_.childCount(number); ++i) todo.push_back(tree_.firstChild(number) + i);
    }
    return error;
  }

  glm::dvec3 toModel(PositionCode position) const {
    return glm::dvec3(unpackPosition(position)) * reader_.summary().lattice.step;
  }

  VerifyOptions options_;
  Reader reader_;
  NodeTree tree_;
  OpenEdges leaf_edges_;
  VerifyReport report_;
};

}  // namespace

VerifyReport verifyStore(const std::filesystem::path& path, const VerifyOptions& options) {
  return Verifier(path, options).run();
}

}  // namespace lode::store
