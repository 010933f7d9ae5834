#include "tests/bench/paper_operator.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <vector>

#include "common/node_key.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/simplify/cluster.h"

namespace lode::bench {
namespace {

using ingest::NodeMesh;

/// Octant of a triangle's centroid in a cell of the tree over the whole lattice.
unsigned octantOf(glm::uvec3 corner_sum, int depth) {
  const glm::uvec3 centroid = corner_sum / 3u >> static_cast<uint32_t>(kLatticeBits - 1 - depth) & 1u;
  return centroid.x | centroid.y << 1 | centroid.z << 2;
}

class PaperTree {
 public:
  PaperTree(const FileNode& model, uint32_t leaf_triangles)
      : model_(model), leaf_triangles_(leaf_triangles), leaf_of_(model.mesh.triangles.size()) {
    std::vector<uint32_t> all(model.mesh.triangles.size());
    for (uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    // The lattice is larger than the model: begin with the smallest cell that holds it.
    const uint32_t longest = std::max({model.extent.x, model.extent.y, model.extent.z, 1u});
    skipped_ = kLatticeBits - static_cast<int>(std::bit_width(longest));
    split(kRootKey, std::move(all));
    lockShared();
  }

  /// Meshes by depth; each level is the parents of the one before it, and leaves above.
  void run(const std::function<void(int, test::TriangleSoup&&)>& visit) {
    int depth = 0;
    for (const auto& [key, leaf] : leaves_) depth = std::max(depth, key.depth());
    std::map<NodeKey, NodeMesh> level;
    for (auto& [key, mesh] : leaves_) level.emplace(key, std::move(mesh));
    while (--depth >= 0) {
      std::map<NodeKey, std::vector<NodeMesh>> parents;
      std::map<NodeKey, NodeMesh> next;
      for (auto& [key, mesh] : level) {
        if (key.depth() > depth) {
          parents[key.parent()].push_back(std::move(mesh));
        } else {
          next.emplace(key, std::move(mesh));
        }
      }
      for (const auto& [key, meshes] : parents) next.emplace(key, makeOne(key, meshes));
      level = std::move(next);
      test::TriangleSoup cut;
      for (const auto& [key, mesh] : level) {
        const test::TriangleSoup part = latticeSoup(mesh);
        cut.insert(cut.end(), part.begin(), part.end());
      }
      visit(depth, std::move(cut));
    }
  }

 private:
  void split(NodeKey key, std::vector<uint32_t>&& triangles) {
    if (triangles.size() <= leaf_triangles_ || key.depth() + skipped_ == kMaxDepth) {
      for (const uint32_t t : triangles) leaf_of_[t] = key;
      return;
    }
    std::array<std::vector<uint32_t>, 8> octants;
    for (const uint32_t i : triangles) {
      glm::uvec3 sum(0);
      for (int k = 0; k < 3; ++k) sum += positionOf(model_.mesh.triangles[i][k]);
      octants[octantOf(sum, key.depth() + skipped_)].push_back(i);
    }
    triangles = {};
    for (unsigned octant = 0; octant < 8; ++octant)
      if (!octants[octant].empty()) split(key.child(octant), std::move(octants[octant]));
  }

  glm::uvec3 positionOf(uint32_t wedge) const {
    return unpackPosition(model_.mesh.positions[model_.mesh.wedge_position[wedge]]);
  }

  /// Makes the leaves' meshes, each shared position with the depth of its leaves' common ancestor.
  void lockShared() {
    const NodeMesh& mesh = model_.mesh;
    std::vector<NodeKey> common(mesh.positions.size(), NodeKey{0});
    std::vector<bool> is_shared(mesh.positions.size());
    std::map<NodeKey, std::vector<uint32_t>> triangles;
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      triangles[leaf_of_[i]].push_back(i);
      for (int k = 0; k < 3; ++k) {
        const uint32_t position = mesh.wedge_position[mesh.triangles[i][k]];
        NodeKey& key = common[position];
        if (key.value == 0) key = leaf_of_[i];
        if (key == leaf_of_[i]) continue;
        key = commonAncestor(key, leaf_of_[i]);
        is_shared[position] = true;
      }
    }
    for (const auto& [key, numbers] : triangles) {
      welder_.begin({}, 3 * numbers.size(), numbers.size());
      for (const uint32_t i : numbers) {
        glm::u32vec3 wedges;
        for (int k = 0; k < 3; ++k) {
          const uint32_t position = mesh.wedge_position[mesh.triangles[i][k]];
          const auto lca =
              is_shared[position] ? static_cast<uint8_t>(common[position].depth()) : ingest::kNeverLocked;
          wedges[k] = welder_.addCorner(mesh.positions[position], lca, {});
        }
        welder_.addTriangle(wedges);
      }
      leaves_.emplace(key, welder_.finish());
    }
  }

  NodeMesh makeOne(NodeKey key, const std::vector<NodeMesh>& meshes) {
    std::vector<std::vector<uint32_t>> became;
    NodeMesh result;
    ingest::cluster(ingest::mergeMeshes(meshes, became), std::array{size_t{0}},
                    {.node_depth = key.depth(), .max_position = model_.extent},
                    [&](size_t, ingest::SimplifiedMesh&& one) { result = std::move(one.mesh); });
    return result;
  }

  const FileNode& model_;
  const uint32_t leaf_triangles_;
  int skipped_ = 0;  ///< levels above the smallest cell that holds the model
  std::vector<NodeKey> leaf_of_;
  std::map<NodeKey, NodeMesh> leaves_;
  ingest::MeshWelder welder_;
};

}  // namespace

void simplifyAsThePaper(const FileNode& model, uint32_t leaf_triangles,
                        const std::function<void(int depth, test::TriangleSoup&& lattice_soup)>& visit) {
  PaperTree(model, leaf_triangles).run(visit);
}

}  // namespace lode::bench
