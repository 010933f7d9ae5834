#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "common/codec/draco_codec.h"
#include "server/store/export.h"
#include "server/store/reader.h"
#include "server/store/writer.h"

namespace lode::ingest {

/// Writes a valid copy of a store after applying the functions to its nodes and leaf meshes.
inline void alterStore(const std::filesystem::path& from, const std::filesystem::path& to,
                       const std::function<void(Node&)>& alter_node,
                       const std::function<void(Mesh&)>& alter_leaf) {
  const store::Reader reader(from);
  const double step = reader.summary().lattice.step;
  std::vector<Node> nodes(reader.nodes().begin(), reader.nodes().end());
  store::Writer writer(to);
  for (Node& node : nodes) {
    node.child_page = {};
    for (uint32_t r = 0; r < node.lods.size(); ++r) {
      if (!node.lods[r].payload) continue;
      std::vector<std::byte> bytes = reader.readBlob(node.lods[r].payload.number);
      if (node.isLeaf() && alter_leaf) {
        Mesh mesh = store::readLod(reader, node, r);
        alter_leaf(mesh);
        const EncodedPayload payload = encodePayload(mesh, step);
        node.lods[r].vertices = payload.vertices;
        bytes = payload.bytes;
      }
      node.lods[r].payload = writer.addBlob(bytes);
    }
    if (alter_node) alter_node(node);
  }
  writer.addTextures(reader.textures());
  writer.finish(reader.summary(), std::move(nodes));
}

}  // namespace lode::ingest
