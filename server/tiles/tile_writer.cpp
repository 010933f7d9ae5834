#include "server/tiles/tile_writer.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/error.h"
#include "common/io/little_endian_row.h"
#include "server/store/export.h"
#include "server/store/node_tree.h"
#include "server/store/tile_encoder.h"
#include "server/tiles/glb.h"
#include "server/tiles/texture_levels.h"
#include "server/tiles/tile_content.h"
#include "server/tiles/tile_frame.h"

namespace lode::tiles {
namespace {

using Json = nlohmann::ordered_json;

/// Version of the files that TileWriter makes. Increment it when the bytes of a file change, because caches
/// assume that a name's bytes never change.
constexpr uint32_t kWriterVersion = 2;

Json boundingVolume(const LatticeBox& lattice_box, double step) {
  const ModelBox box = toModelBox(lattice_box, step);
  const glm::dvec3 c = box.centre, h = box.half;
  return {{"box", {c.x, c.y, c.z, h.x, 0.0, 0.0, 0.0, h.y, 0.0, 0.0, 0.0, h.z}}};
}

Json numbersOf(const glm::dmat4& matrix) {
  Json numbers = Json::array();
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) numbers.push_back(matrix[column][row]);
  return numbers;
}

void addDigest(LittleEndianRow& row, const Digest& digest) {
  for (const std::byte byte : digest.bytes) row.add(std::to_integer<uint8_t>(byte));
}

/// Returns a digest of all tiles of a texture. The texels of all levels depend only on these tiles.
Digest digestOfTexels(const Texture& texture) {
  std::vector<std::byte> digests;
  digests.reserve(texture.tiles.size() * sizeof(Digest));
  for (const BlobRef& tile : texture.tiles)
    digests.insert(digests.end(), tile.digest.bytes.begin(), tile.digest.bytes.end());
  LittleEndianRow values;
  addDigest(values, digestOf(digests));
  values.add(texture.width);
  values.add(texture.height);
  return digestOf(values.bytes());
}

}  // namespace

/// Makes the tiles of one page.
class TileWriter::PageMaker {
 public:
  /// @param folder  path from the page's folder to the tileset's.
  PageMaker(const TileWriter& writer, const char* folder, TilesetPage& page)
      : writer_(writer), folder_(folder), page_(page) {}

  /// Returns the tile of a node's coarsest LOD with all its descendants. @param above_model  see tileChain().
  Json chainOf(const Node& node, double above_model) {
    const std::vector<TileLod> chain = tileChain(node, above_model);
    Json below = continuesBelow(node, chain) ? childrenOf(node, chain.back().error_model) : Json::array();
    for (auto lod = chain.rbegin(); lod != chain.rend(); ++lod) {
      Json tile = tileOf(node, lod->error_model);
      addContent(tile, node, lod->lod);
      if (!below.empty()) tile["children"] = std::move(below);
      below = Json::array();
      below.push_back(std::move(tile));
      ++page_.tiles;
    }
    return std::move(below.front());
  }

  /// Returns the chains of a node's children on this page.
  Json chainsBelow(const Node& node, double error_model) {
    Json chains = Json::array();
    for (unsigned octant = 0; octant < 8; ++octant) {
      if ((node.child_mask >> octant & 1) == 0) continue;
      const Node& child = writer_.nodeOf(node.key.child(octant));
      if (!child.box.empty()) chains.push_back(chainOf(child, error_model));
    }
    return chains;
  }

  Json tileOf(const Node& node, double error_model) const {
    return {{"boundingVolume", boundingVolume(node.box, writer_.reader_.summary().lattice.step)},
            {"geometricError", error_model}};
  }

 private:
  /// Returns the tiles below a node's finest LOD: its children, or a reference to the page that contains
  /// them.
  Json childrenOf(const Node& node, double error_model) {
    if (!node.child_page) return chainsBelow(node, error_model);
    page_.pages.push_back(node.key);
    Json reference = tileOf(node, error_model);
    reference["content"]["uri"] = folder_ + writer_.pageName(node, error_model);
    Json children = Json::array();
    children.push_back(std::move(reference));
    return children;
  }

  void addContent(Json& tile, const Node& node, uint32_t lod) {
    if (!node.lods[lod].payload) return;
    const auto number = static_cast<uint32_t>(&node - writer_.reader_.nodes().data());
    page_.contents.push_back({number, lod});
    tile["content"]["uri"] = folder_ + writer_.glbName(page_.contents.back());
  }

  const TileWriter& writer_;
  const std::string folder_;
  TilesetPage& page_;
};

TileWriter::TileWriter(const store::Reader& reader, const glm::dmat4& root_transform)
    : reader_(reader), root_transform_(root_transform) {
  if (!reader.summary().attributes.has(AttributeSet::kTexture)) return;
  const TextureLevels levels(reader);
  for (uint32_t i = 0; i < reader.textures().textures.size(); ++i) {
    const Texture& texture = reader.textures().textures[i];
    NamedTexture& named = textures_.emplace_back();
    if (texture.tiles.empty()) continue;
    named = {digestOfTexels(texture), levels.isJpeg(i) ? ".jpg" : ".webp"};
    has_images_ = true;
  }
}

TilesetPage TileWriter::page(NodeKey owner) const {
  const Node& node = nodeOf(owner);
  const bool is_root = owner == kRootKey;
  TilesetPage page;
  PageMaker maker(*this, is_root ? "" : "../", page);
  Json document;
  document["asset"] = {{"version", "1.1"}};
  Json root;
  if (is_root) {
    document["asset"]["tilesetVersion"] = toHex(reader_.summary().build_id);
    document["geometricError"] = errorOfTileset();
    root = maker.chainOf(node, errorOfTileset());
    root["transform"] = numbersOf(root_transform_);
  } else {
    const double error_model = finestError(owner);
    document["geometricError"] = error_model;
    root = maker.tileOf(node, error_model);
    Json children = maker.chainsBelow(node, error_model);
    if (!children.empty()) root["children"] = std::move(children);
  }
  root["refine"] = "REPLACE";
  document["root"] = std::move(root);
  page.json = document.dump();
  return page;
}

std::string TileWriter::pageName(NodeKey owner) const {
  return owner == kRootKey ? "tileset.json" : pageName(nodeOf(owner), finestError(owner));
}

std::string TileWriter::pageName(const Node& owner, double error_model) const {
  // The name is the digest of all values that determine the page's bytes.
  LittleEndianRow values;
  addDigest(values, owner.child_page.digest);
  values.add(kWriterVersion);
  values.add(reader_.summary().lattice.step);
  values.add(error_model);
  for (const glm::uvec3& corner : {owner.box.min, owner.box.max})
    for (int axis = 0; axis < 3; ++axis) values.add(corner[axis]);
  return "p/" + toHex(digestOf(values.bytes())) + ".json";
}

TileGlb TileWriter::glb(store::CutItem item) const {
  const Node& node = reader_.nodes()[item.node];
  const double step = reader_.summary().lattice.step;
  const store::DecodedLod lod = store::decodeLod(reader_, node, item.lod);
  if (!has_images_) return {encodeGlb(plainContent(lod, step)), {}};
  TileGlb glb;
  TextureLevels levels(reader_);
  const auto uri_of = [&](SharedImage image) {
    glb.images.push_back(image);
    return "../" + imageName(image);
  };
  glb.bytes = encodeGlb(
      texturedContent(lod.mesh, reader_.textures(), step, node.lods[item.lod].offModel(), levels, uri_of));
  return glb;
}

std::string TileWriter::glbName(store::CutItem item) const {
  const Lod& lod = reader_.nodes()[item.node].lods[item.lod];
  Digest digest = lod.payload.digest;
  if (has_images_) {
    LittleEndianRow values;
    addDigest(values, digest);
    addDigest(values, reader_.summary().textures.digest);
    values.add(lod.offModel());
    digest = digestOf(values.bytes());
  }
  return "g/" + toHex(digest) + "." + std::to_string(kWriterVersion) + ".glb";
}

std::vector<std::byte> TileWriter::image(SharedImage image) const {
  TextureLevels levels(reader_);
  const Image whole =
      levels.part(image.texture, image.level, {0, 0}, levels.size(image.texture, image.level));
  if (levels.isJpeg(image.texture)) return store::encodeTile(whole, store::TileCodec::kJpeg, kImageQuality);
  const bool is_drawing = store::chooseCodec(whole) == store::TileCodec::kLossless;
  return store::encodeTile(whole, is_drawing ? store::TileCodec::kLossless : store::TileCodec::kWebp,
                           kImageQuality);
}

std::string TileWriter::imageName(SharedImage image) const {
  const NamedTexture& texture = textures_[image.texture];
  LittleEndianRow values;
  addDigest(values, texture.digest);
  values.add(image.level);
  return "i/" + toHex(digestOf(values.bytes())) + "." + std::to_string(kWriterVersion) + texture.extension;
}

const Node& TileWriter::nodeOf(NodeKey key) const {
  const Node* const node = reader_.find(key);
  if (node == nullptr)
    throw Error(ErrorCode::kInternal,
                reader_.path().string() + ": a tileset refers to a node that does not exist");
  return *node;
}

double TileWriter::errorOfTileset() const {
  const ModelSummary& summary = reader_.summary();
  return toNineDigits(2 * glm::length(toModelBox(summary.box, summary.lattice.step).half));
}

double TileWriter::finestError(NodeKey key) const {
  double error_model = errorOfTileset();
  for (int depth = 0; depth <= key.depth(); ++depth)
    error_model = tileChain(nodeOf(key.ancestorAt(depth)), error_model).back().error_model;
  return error_model;
}

}  // namespace lode::tiles
