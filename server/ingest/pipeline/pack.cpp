#include "server/ingest/pipeline/pack.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace lode::ingest {
namespace {

constexpr uint32_t kLargeTriangles = 1 << 19;
/// Ratio of the distances from the eye to the farthest and to the nearest sibling, in a view of a whole
/// model.
constexpr float kFartherSibling = 2;

}  // namespace

void removeRedundantFarLods(FinishedNode& finished, const Node& parent) {
  Node& node = finished.node;
  const Lod& finest = parent.lods.front();
  const float most = (finest.triangles < kLargeTriangles ? 1 : kFartherSibling) * finest.offModel();
  while (node.far_lods > 1) {
    const auto finer = static_cast<std::ptrdiff_t>(node.lods.size()) - 2;
    if (node.lods[finer].offModel() <= most) return;
    node.lods.erase(node.lods.begin() + finer);
    finished.payloads.erase(finished.payloads.begin() + finer);
    --node.far_lods;
  }
}

void packTextures(const StagedTextures& textures, const UvGrid& grid, const Spool* tiles,
                  store::Writer& writer) {
  TextureSet set{grid.origin, grid.scale_exponent, {}};
  uint32_t levels = 0;
  for (const StagedTextures::Texture& texture : textures.textures) {
    set.textures.push_back({texture.name, texture.width, texture.height, {}});
    set.textures.back().tiles.resize(texture.tiles.size());
    levels = std::max(levels, levelCount(set.textures.back()));
  }
  std::vector<std::byte> bytes;
  for (uint32_t rank = 0; rank < levels; ++rank)  // rank 0 is the coarsest level of every texture
    for (size_t t = 0; t < set.textures.size(); ++t) {
      Texture& texture = set.textures[t];
      if (rank >= levelCount(texture)) continue;
      const uint32_t level = levelCount(texture) - 1 - rank;
      const size_t first = tileIndex(texture, level, 0, 0);
      const size_t end = first + size_t{tilesAcross(texture, level)} * tilesDown(texture, level);
      for (size_t i = first; i < end; ++i) {
        bytes.resize(textures.textures[t].tiles[i].bytes);
        tiles->readAt(textures.textures[t].tiles[i].offset, bytes);
        texture.tiles[i] = writer.addBlob(bytes);
      }
    }
  writer.addTextures(set);
}

ModelSummary pack(store::Writer& writer, ModelSummary summary, BuiltTree& tree,
                  const BuildProgress& progress) {
  std::vector<Node> packed;
  packed.reserve(tree.size());
  for (const BuiltTree::Place& place : tree.sorted()) {
    FinishedNode finished = tree.read(place);
    if (finished.node.far_lods > 1)
      removeRedundantFarLods(finished,
                             *std::ranges::lower_bound(packed, finished.node.key.parent(), {}, &Node::key));
    for (size_t r = finished.node.lods.size(); r-- > 0;) {
      const PayloadPlace payload = finished.payloads[r];
      if (payload.bytes > 0) finished.node.lods[r].payload = writer.addBlob(tree.readPayload(place, payload));
    }
    packed.push_back(std::move(finished.node));
    if (progress && packed.size() % 256 == 1) {
      progress("pack", static_cast<double>(packed.size()) / static_cast<double>(packed.capacity()),
               packed.size(), packed.capacity());
    }
  }
  return writer.finish(std::move(summary), std::move(packed));
}

}  // namespace lode::ingest
