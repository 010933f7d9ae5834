#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/hierarchy.h"
#include "client/core/lod/triangle_clusters.h"
#include "common/codec/hierarchy_page.h"

namespace lode::core::fixture {

/// A random octree with boxes, LODs and errors as in a store, split into pages as in docs/store-format.md.
/// Meshes have the announced numbers of vertices and triangles. Some triangles cover the sides of the node's
/// box once; the others are degenerate.
class SyntheticModel {
 public:
  struct Options {
    uint32_t seed = 1;
    int depth = 4;
    double split_chance = 0.8;
    double child_chance = 0.6;
    double empty_chance = 0;  ///< chance that a node's coarsest LOD is empty
    uint32_t payload_bytes_a_triangle = 1;
    uint32_t most_far_lods = 2;  ///< far LODs of an inner node below the root
  };

  explicit SyntheticModel(Options options)
      : options_(options), random_(options.seed), spare_random_(options.seed) {
    LatticeBox box;
    box.add(glm::uvec3(0));
    box.add(glm::uvec3(1u << 20));
    grow(kRootKey, box, 4096.0f, 8192.0f);
  }

  static Lattice lattice() { return {{0, 0, 0}, 1.0 / 1024}; }
  static AttributeSet attributes() { return {AttributeSet::kNormal}; }
  static double boxSide() { return 1024; }

  const std::map<NodeKey, Node>& nodes() const { return nodes_; }

  HierarchyPage rootPage() const { return {collect(kRootKey, 0, 2)}; }
  HierarchyPage pageBelow(NodeKey owner) const { return {collect(owner, 1, 2)}; }

  /// Returns the whole tree.
  Hierarchy hierarchy() const {
    Hierarchy all(nodes_.size());
    all.addRootPage(rootPage());
    for (const auto& [key, node] : nodes_)
      if (node.child_page) all.addPage(key, pageBelow(key));
    return all;
  }

  std::shared_ptr<const Mesh> mesh(MeshKey key) const {
    constexpr uint32_t kSides[12][3] = {{0, 1, 3}, {0, 3, 2}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                        {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 3, 7}, {1, 7, 5}};
    const Node& node = nodes_.at(key.node);
    const Lod& lod = node.lods[key.lod];
    Mesh mesh;
    mesh.attributes = attributes();
    for (uint32_t vertex = 0; vertex < lod.vertices; ++vertex) {
      const auto side = [&](int axis) {
        return (vertex >> axis & 1) != 0 ? node.box.max[axis] : node.box.min[axis];
      };
      mesh.positions.push_back(packPosition({side(0), side(1), side(2)}));
    }
    mesh.vertex_attributes.resize(lod.vertices);
    for (uint32_t i = 0; i < lod.triangles; ++i)
      mesh.triangles.push_back(i < 12 ? glm::u32vec3(kSides[i][0], kSides[i][1], kSides[i][2])
                                      : glm::u32vec3(0));
    clusterTriangles(mesh);
    return std::make_shared<const Mesh>(std::move(mesh));
  }

  std::vector<NodeKey> leaves() const {
    std::vector<NodeKey> keys;
    for (const auto& [key, node] : nodes_)
      if (node.isLeaf()) keys.push_back(key);
    return keys;
  }

 private:
  double chance() { return std::uniform_real_distribution<double>()(random_); }

  void grow(NodeKey key, const LatticeBox& box, float error_model, float appearance_cap) {
    Node node;
    node.key = key;
    node.box = box;
    const bool splits = key.depth() < options_.depth && (key == kRootKey || chance() < options_.split_chance);
    const uint32_t lods = key == kRootKey ? 4 : splits ? 1 + static_cast<uint32_t>(random_() % 3) : 1;
    for (uint32_t r = 0; r < lods; ++r) {
      Lod lod;
      lod.triangles = (20 + static_cast<uint32_t>(random_() % 20)) << (lods - 1 - r);
      lod.vertices = lod.triangles / 2 + 2;
      lod.error_model =
          error_model * (splits || key == kRootKey ? 1.0f : 0.01f) / static_cast<float>(1u << (lods - 1 - r));
      lod.appearance_error_model =
          std::min(appearance_cap, lod.error_model * static_cast<float>(random_() % 2) * 1.25f);
      lod.payload = {next_blob_++, 100 + lod.triangles * options_.payload_bytes_a_triangle, {}};
      node.lods.push_back(lod);
    }
    for (size_t r = lods - 1; r-- > 0;)
      node.lods[r].appearance_error_model =
          std::min(node.lods[r].appearance_error_model, node.lods[r + 1].appearance_error_model);
    if (splits && key != kRootKey) addFarLods(node);
    if (key != kRootKey && chance() < options_.empty_chance) {
      node.lods.back().triangles = node.lods.back().vertices = 0;
      node.lods.back().payload = {};
    }
    const float child_error = node.lods.front().error_model / 2;
    if (splits) {
      for (unsigned octant = 0; octant < 8; ++octant)
        if (chance() < options_.child_chance || octant == random_() % 8)
          node.child_mask |= static_cast<uint8_t>(1u << octant);
      if (node.child_mask == 0) node.child_mask = 1;
      if (key.depth() >= 2 && key.depth() % 2 == 0) node.child_page = {next_blob_++, 1000, {}};
    }
    nodes_[key] = node;
    for (unsigned octant = 0; octant < 8; ++octant)
      if ((node.child_mask >> octant & 1) != 0)
        grow(key.child(octant), childBox(box, octant), child_error, node.lods.front().appearance_error_model);
  }

  /// Adds LODs with twice and four times the error of the last one, which may exceed the parent's error.
  void addFarLods(Node& node) {
    node.far_lods = static_cast<uint32_t>(spare_random_() % (options_.most_far_lods + 1));
    for (uint32_t i = 0; i < node.far_lods; ++i) {
      Lod lod = node.lods.back();
      lod.triangles = std::max(12u, lod.triangles * 2 / 3);
      lod.vertices = lod.triangles / 2 + 2;
      lod.error_model *= 2;
      lod.appearance_error_model *= 2;
      lod.payload = {next_blob_++, 100 + lod.triangles * options_.payload_bytes_a_triangle, {}};
      node.lods.push_back(lod);
    }
  }

  static LatticeBox childBox(const LatticeBox& box, unsigned octant) {
    const glm::uvec3 middle = (box.min + box.max) / 2u;
    LatticeBox child;
    for (int axis = 0; axis < 3; ++axis) {
      const bool upper = (octant >> axis & 1) != 0;
      child.min[axis] = upper ? middle[axis] : box.min[axis];
      child.max[axis] = upper ? box.max[axis] : middle[axis];
    }
    return child;
  }

  std::vector<Node> collect(NodeKey owner, int from_level, int to_level) const {
    std::vector<Node> found;
    for (const auto& [key, node] : nodes_) {
      const int level = key.depth() - owner.depth();
      if (level >= from_level && level <= to_level && owner.contains(key)) found.push_back(node);
    }
    return found;
  }

  Options options_;
  std::mt19937 random_, spare_random_;
  uint32_t next_blob_ = 1;
  std::map<NodeKey, Node> nodes_;
};

}  // namespace lode::core::fixture
