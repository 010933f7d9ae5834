#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <filesystem>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "common/codec/draco_codec.h"
#include "common/error.h"
#include "server/store/writer.h"
#include "tests/support/test_meshes.h"
#include "tests/support/work_folder.h"

/// Small but complete stores for the tests of all modules that read stores. They satisfy the invariants: a
/// coarser LOD is the image of a finer LOD under a map of vertices, and this map leaves the vertices fixed
/// that leaves share.
namespace lode::test {

/// A hierarchy with the meshes of its LODs, for writeStore().
struct SyntheticModel {
  ModelSummary summary;     ///< summary with lattice and attributes
  std::vector<Node> nodes;  ///< nodes in key order, without payloads
  std::map<std::pair<NodeKey, uint32_t>, Mesh> meshes;
};

struct SyntheticOptions {
  size_t leaf_triangles = 24;  ///< a node with more triangles is split
  uint32_t lods = 2;           ///< number of LODs of an inner node, without far LODs
  uint32_t far_lods = 0;       ///< number of far LODs of an inner node below the root
  int extent_bits = 12;        ///< the root's cell is 2^extent_bits lattice steps long
  Lattice lattice{{100.5, -20.25, 3.75}, 0.25};
};

namespace detail {

class ModelMaker {
 public:
  ModelMaker(const Mesh& mesh, const SyntheticOptions& options) : options_(options), whole_(mesh) {
    model_.summary.lattice = options.lattice;
    model_.summary.attributes = mesh.attributes;
    model_.summary.triangles_per_node = static_cast<uint32_t>(options.leaf_triangles);
  }

  SyntheticModel make() {
    split(kRootKey, glm::uvec3(0), whole_.triangles);
    for (auto leaf = leaves_.rbegin(); leaf != leaves_.rend(); ++leaf) noteSharing(leaf->first, leaf->second);
    simplify(kRootKey);
    std::sort(model_.nodes.begin(), model_.nodes.end(),
              [](const Node& a, const Node& b) { return a.key < b.key; });
    return std::move(model_);
  }

 private:
  void split(NodeKey key, glm::uvec3 corner, const std::vector<glm::u32vec3>& triangles) {
    const int bits = options_.extent_bits - key.depth();
    if (triangles.size() <= options_.leaf_triangles || bits <= 0) {
      leaves_[key] = triangles;
      return;
    }
    std::array<std::vector<glm::u32vec3>, 8> parts;
    const glm::uvec3 middle = corner + glm::uvec3(1u << (bits - 1));
    for (const glm::u32vec3 t : triangles) {
      const glm::uvec3 sum = unpackPosition(whole_.positions[t.x]) + unpackPosition(whole_.positions[t.y]) +
                             unpackPosition(whole_.positions[t.z]);
      const glm::uvec3 high(glm::greaterThanEqual(sum, 3u * middle));
      parts[high.x | high.y << 1 | high.z << 2].push_back(t);
    }
    for (unsigned octant = 0; octant < 8; ++octant) {
      if (parts[octant].empty()) continue;
      masks_[key] = static_cast<uint8_t>(masks_[key] | 1u << octant);
      const glm::uvec3 high(octant & 1, octant >> 1 & 1, octant >> 2);
      split(key.child(octant), corner + (high << static_cast<unsigned>(bits - 1)), parts[octant]);
    }
  }

  void noteSharing(NodeKey leaf, const std::vector<glm::u32vec3>& triangles) {
    for (const glm::u32vec3 t : triangles)
      for (int i = 0; i < 3; ++i) {
        const auto [entry, is_new] = shared_below_.try_emplace(whole_.positions[t[i]], leaf);
        if (!is_new) entry->second = commonAncestor(entry->second, leaf);
      }
  }

  bool locked(NodeKey key, PositionCode position) const {
    return shared_below_.at(position).depth() < key.depth();
  }

  /// Returns the part of the whole mesh that the triangles use.
  Mesh extract(const std::vector<glm::u32vec3>& triangles) const {
    Mesh mesh;
    mesh.attributes = whole_.attributes;
    std::map<uint32_t, uint32_t> numbers;
    for (const glm::u32vec3 t : triangles) {
      glm::u32vec3 renumbered;
      for (int i = 0; i < 3; ++i) {
        const auto [entry, is_new] = numbers.try_emplace(t[i], static_cast<uint32_t>(mesh.positions.size()));
        renumbered[i] = entry->second;
        if (!is_new) continue;
        mesh.positions.push_back(whole_.positions[t[i]]);
        if (!whole_.vertex_attributes.empty())
          mesh.vertex_attributes.push_back(whole_.vertex_attributes[t[i]]);
      }
      mesh.triangles.push_back(renumbered);
    }
    return mesh;
  }

  /// Moves every third unlocked vertex onto a neighbour, and drops the triangles that become degenerate.
  std::vector<glm::u32vec3> coarsen(NodeKey key, const std::vector<glm::u32vec3>& triangles) const {
    std::map<PositionCode, uint32_t> target;
    uint32_t count = 0;
    for (const glm::u32vec3 t : triangles)
      for (int i = 0; i < 3; ++i) {
        const PositionCode position = whole_.positions[t[i]];
        if (!target.contains(position))
          target[position] = !locked(key, position) && count++ % 3 == 0 ? t[(i + 1) % 3] : t[i];
      }
    std::vector<glm::u32vec3> result;
    for (const glm::u32vec3 t : triangles) {
      glm::u32vec3 moved;
      for (int i = 0; i < 3; ++i) {
        const uint32_t to = target[whole_.positions[t[i]]];
        moved[i] = whole_.positions[to] == whole_.positions[t[i]] ? t[i] : to;
      }
      const PositionCode a = whole_.positions[moved.x], b = whole_.positions[moved.y],
                         c = whole_.positions[moved.z];
      if (a != b && b != c && c != a) result.push_back(moved);
    }
    return result;
  }

  void addLod(Node& node, const std::vector<glm::u32vec3>& triangles) {
    const Mesh mesh = extract(triangles);
    Lod lod;
    lod.triangles = static_cast<uint32_t>(triangles.size());
    lod.vertices = static_cast<uint32_t>(mesh.positions.size());
    std::vector<PositionCode> distinct = mesh.positions;
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    lod.locked = static_cast<uint32_t>(std::count_if(
        distinct.begin(), distinct.end(), [&](PositionCode position) { return locked(node.key, position); }));
    const auto step = static_cast<float>(options_.lattice.step);
    const auto extent = static_cast<float>(1u << options_.extent_bits);
    const int above_parents = node.lods.size() >= options_.lods ? 2 : 0;
    lod.error_model = node.isLeaf() && node.lods.empty()
                          ? step
                          : step * extent *
                                std::ldexp(1.0f + 0.1f * static_cast<float>(node.lods.size()),
                                           above_parents - node.key.depth());
    node.box.add(boxOf(mesh));
    model_.meshes[{node.key, static_cast<uint32_t>(node.lods.size())}] = mesh;
    node.lods.push_back(lod);
  }

  /// Makes the LODs of a node. @return the triangles from which the parent is made.
  std::vector<glm::u32vec3> simplify(NodeKey key) {
    Node node;
    node.key = key;
    std::vector<glm::u32vec3> triangles;
    if (const auto leaf = leaves_.find(key); leaf != leaves_.end()) {
      triangles = leaf->second;
      addLod(node, triangles);
    } else {
      node.child_mask = masks_[key];
      for (unsigned octant = 0; octant < 8; ++octant) {
        if ((node.child_mask >> octant & 1) == 0) continue;
        const auto part = simplify(key.child(octant));
        triangles.insert(triangles.end(), part.begin(), part.end());
        node.box.add(boxes_[key.child(octant)]);
      }
    }
    while (!node.isLeaf() && node.lods.size() < options_.lods) {
      triangles = coarsen(key, triangles);
      addLod(node, triangles);
    }
    std::vector<glm::u32vec3> coarser = triangles;
    while (!node.isLeaf() && key != kRootKey && node.far_lods < options_.far_lods) {
      coarser = coarsen(key, coarser);
      addLod(node, coarser);
      ++node.far_lods;
    }
    boxes_[key] = node.box;
    model_.nodes.push_back(node);
    return triangles;
  }

  SyntheticOptions options_;
  const Mesh& whole_;
  SyntheticModel model_;
  std::map<NodeKey, std::vector<glm::u32vec3>> leaves_;
  std::map<NodeKey, uint8_t> masks_;
  std::map<NodeKey, LatticeBox> boxes_;
  std::map<PositionCode, NodeKey> shared_below_;
};

}  // namespace detail

inline SyntheticModel makeModel(const Mesh& mesh, const SyntheticOptions& options = {}) {
  return detail::ModelMaker(mesh, options).make();
}

/// Adds a texture of any size. Its tiles are not images, but begin like JPEG files.
inline Texture addFakeTexture(store::Writer& writer, const std::string& name, uint32_t width,
                              uint32_t height) {
  Texture texture{name, width, height, {}};
  const uint64_t tiles = tileCount(texture);
  for (uint64_t i = 0; i < tiles; ++i) {
    const std::string bytes = "\xff\xd8\xff" + name + std::to_string(i);
    texture.tiles.push_back(writer.addBlob(std::as_bytes(std::span(bytes))));
  }
  return texture;
}

/// Encodes the LODs and writes the store, coarse LODs first. Sets the payloads of the model.
/// @param add_textures  function that adds tiles and returns the model's texture set.
inline ModelSummary writeStore(const std::filesystem::path& path, SyntheticModel& model,
                               const std::function<TextureSet(store::Writer&)>& add_textures = {}) {
  store::Writer writer(path);
  if (add_textures) writer.addTextures(add_textures(writer));
  for (Node& node : model.nodes)
    for (auto lod = static_cast<uint32_t>(node.lods.size()); lod-- > 0;) {
      const EncodedPayload payload =
          encodePayload(model.meshes.at({node.key, lod}), model.summary.lattice.step);
      node.lods[lod].vertices = payload.vertices;
      node.lods[lod].payload = writer.addBlob(payload.bytes);
    }
  return writer.finish(model.summary, model.nodes);
}

}  // namespace lode::test
