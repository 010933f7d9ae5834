#include "server/tiles/tile_writer.h"

#include <functional>
#include <map>
#include <random>
#include <regex>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server/store/export.h"
#include "server/store/node_tree.h"
#include "server/store/open_edges.h"
#include "tests/support/synthetic_store.h"
#include "tests/unit/tiles/glb_file.h"

namespace lode::tiles {
namespace {

using Json = nlohmann::json;

/// A store of a synthetic model, and its tileset.
class TilesOf {
 public:
  explicit TilesOf(test::SyntheticModel model, const glm::dmat4& root = glm::dmat4(1))
      : model_(std::move(model)),
        summary_(test::writeStore(folder_ / "m.lode", model_)),
        reader_(folder_ / "m.lode"),
        writer_(reader_, root) {
    std::vector<NodeKey> todo{kRootKey};
    while (!todo.empty()) {
      const NodeKey owner = todo.back();
      todo.pop_back();
      const TilesetPage page = writer_.page(owner);
      pages_[writer_.pageName(owner)] = Json::parse(page.json);
      todo.insert(todo.end(), page.pages.begin(), page.pages.end());
      for (const store::CutItem item : page.contents) items_[writer_.glbName(item)] = item;
      tiles_ += page.tiles;
    }
  }

  const store::Reader& reader() const { return reader_; }
  const TileWriter& writer() const { return writer_; }
  const std::map<std::string, Json>& pages() const { return pages_; }
  const std::map<std::string, store::CutItem>& items() const { return items_; }
  uint64_t tiles() const { return tiles_; }
  const Json& root() const { return pages_.at("tileset.json")["root"]; }

  /// Follows a URI of a page. @return path in the tileset.
  static std::string resolve(const std::string& page, const std::string& uri) {
    return (std::filesystem::path(page).parent_path() / uri).lexically_normal();
  }

  /// Calls visit(tile, error above, page) for each tile, and steps through references to pages.
  void forEachTile(const std::function<void(const Json&, double, const std::string&)>& visit) const {
    walk(root(), pages_.at("tileset.json")["geometricError"], "tileset.json", visit);
  }

  void walk(const Json& tile, double above, const std::string& page,
            const std::function<void(const Json&, double, const std::string&)>& visit) const {
    const std::string uri = tile.contains("content") ? tile["content"]["uri"] : "";
    const bool is_page = uri.ends_with(".json");
    if (is_page) {
      const std::string name = resolve(page, uri);
      for (const Json& child : pages_.at(name)["root"]["children"]) walk(child, above, name, visit);
      return;
    }
    visit(tile, above, page);
    if (tile.contains("children"))
      for (const Json& child : tile["children"]) walk(child, tile["geometricError"], page, visit);
  }

 private:
  test::WorkFolder folder_;
  test::SyntheticModel model_;
  ModelSummary summary_;
  store::Reader reader_;
  TileWriter writer_;
  std::map<std::string, Json> pages_;
  std::map<std::string, store::CutItem> items_;
  uint64_t tiles_ = 0;
};

test::SyntheticModel deepModel(test::SyntheticOptions options = {}) {
  return test::makeModel(test::makeSphere(48, 32, {.attributes = {}, .extent = 4000, .seed = 7}), options);
}

TEST(Tileset, hasStrictlyFallingErrors) {
  const TilesOf tiles(deepModel());
  ASSERT_GT(tiles.pages().size(), 1u);
  uint64_t count = 0;
  tiles.forEachTile([&](const Json& tile, double above, const std::string&) {
    EXPECT_LT(tile["geometricError"].get<double>(), above);
    ++count;
  });
  EXPECT_EQ(count, tiles.tiles());
}

TEST(Tileset, hasATileForEachLodOfEachNode) {
  const TilesOf tiles(deepModel());
  uint64_t lods = 0;
  for (const Node& node : tiles.reader().nodes()) lods += tileChain(node, 1e9).size();
  EXPECT_EQ(tiles.tiles(), lods);
}

TEST(Tileset, leavesOutFarLods) {
  const TilesOf tiles(deepModel({.far_lods = 1}));
  ASSERT_GT(std::ranges::max(tiles.reader().nodes(), {}, &Node::far_lods).far_lods, 0u);
  for (const auto& [name, item] : tiles.items()) {
    const Node& node = tiles.reader().nodes()[item.node];
    EXPECT_LT(item.lod, node.lods.size() - node.far_lods) << name;
  }
}

TEST(Tileset, isAChainOfLodsAboveTheChainsOfChildren) {
  const TilesOf tiles(deepModel());
  const auto chain = tileChain(tiles.reader().nodes()[0], 1e9);
  const Json* tile = &tiles.root();
  for (size_t i = 0; i + 1 < chain.size(); ++i) {
    ASSERT_EQ((*tile)["children"].size(), 1u);
    tile = &(*tile)["children"][0];
  }
  EXPECT_EQ((*tile)["content"]["uri"], tiles.writer().glbName({0, 0}));
  EXPECT_EQ((*tile)["children"].size(), store::NodeTree(tiles.reader().nodes()).childCount(0));
}

TEST(Tileset, refersToAPageByATileWithItsOwnersBoxAndError) {
  const TilesOf tiles(deepModel());
  size_t pages = 0;
  tiles.forEachTile([&](const Json& tile, double, const std::string& page) {
    if (!tile.contains("children")) return;
    const Json& child = tile["children"][0];
    if (!child.contains("content") || !child["content"]["uri"].get<std::string>().ends_with(".json")) return;
    const Json& below = tiles.pages().at(TilesOf::resolve(page, child["content"]["uri"]));
    EXPECT_EQ(tile["children"].size(), 1u);
    EXPECT_EQ(child["boundingVolume"], tile["boundingVolume"]);
    EXPECT_EQ(below["root"]["boundingVolume"], tile["boundingVolume"]);
    EXPECT_EQ(child["geometricError"], tile["geometricError"]);
    EXPECT_EQ(below["geometricError"], tile["geometricError"]);
    EXPECT_EQ(below["root"]["refine"], "REPLACE");
    ++pages;
  });
  EXPECT_EQ(pages + 1, tiles.pages().size());
}

TEST(Tileset, hasTheBoxesOfTheNodesInTheModelFrame) {
  const TilesOf tiles(deepModel());
  std::map<std::string, const Node*> nodes;
  for (const auto& [name, item] : tiles.items()) nodes[name] = &tiles.reader().nodes()[item.node];
  tiles.forEachTile([&](const Json& tile, double, const std::string& page) {
    const Node& node = *nodes.at(TilesOf::resolve(page, tile["content"]["uri"]));
    const auto box = tile["boundingVolume"]["box"].get<std::vector<double>>();
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(box[k] - box[3 + 4 * k], node.box.min[k] * 0.25);
      EXPECT_EQ(box[k] + box[3 + 4 * k], node.box.max[k] * 0.25);
    }
  });
}

TEST(Tileset, describesTheRoot) {
  glm::dmat4 root(2);
  root[3] = {10, 20, 30, 1};
  const TilesOf tiles(deepModel(), root);
  EXPECT_EQ(tiles.root()["transform"], Json({2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 10, 20, 30, 1}));
  EXPECT_EQ(tiles.root()["refine"], "REPLACE");
  const Json& tileset = tiles.pages().at("tileset.json");
  EXPECT_EQ(tileset["asset"]["version"], "1.1");
  EXPECT_EQ(tileset["asset"]["tilesetVersion"], toHex(tiles.reader().summary().build_id));
  const LatticeBox box = tiles.reader().summary().box;
  EXPECT_NEAR(tileset["geometricError"], 0.25 * glm::length(glm::dvec3(box.max - box.min)), 1e-4);
}

TEST(Tileset, hasErrorsOfNineDigits) {
  const TilesOf tiles(deepModel());
  tiles.forEachTile([](const Json& tile, double, const std::string&) {
    EXPECT_EQ(tile["geometricError"], toNineDigits(tile["geometricError"]));
  });
}

TEST(Tileset, hasATileWithoutContentForAnLodWithoutTriangles) {
  test::SyntheticModel model = deepModel();
  Node& root = model.nodes[0];
  Lod none;
  none.error_model = 10 * root.lods.back().error_model;
  model.meshes[{kRootKey, static_cast<uint32_t>(root.lods.size())}] = Mesh();
  root.lods.push_back(none);
  const TilesOf tiles(std::move(model));
  EXPECT_FALSE(tiles.root().contains("content"));
  EXPECT_TRUE(tiles.root()["children"][0].contains("content"));
}

TEST(Tileset, ofOneNodeIsOneFile) {
  const TilesOf tiles(
      test::makeModel(test::makeSphere(5, 4, {.attributes = {}, .extent = 4000}), {.leaf_triangles = 1000}));
  EXPECT_EQ(tiles.pages().size(), 1u);
  EXPECT_EQ(tiles.tiles(), 1u);
  EXPECT_FALSE(tiles.root().contains("children"));
}

TEST(Tileset, ofAFlatModelHasBoxesWithAVolume) {
  const TilesOf tiles(test::makeModel(test::makeGrid(8, 8, {.attributes = {}, .extent = 4000, .bump = 0}),
                                      {.leaf_triangles = 24}));
  size_t flat = 0;
  tiles.forEachTile([&](const Json& tile, double, const std::string&) {
    const auto box = tile["boundingVolume"]["box"].get<std::vector<double>>();
    for (const int k : {3, 7, 11}) EXPECT_GE(box[k], 0.125);
    flat += box[11] == 0.125;
  });
  EXPECT_EQ(flat, tiles.tiles());
}

TEST(Tileset, endsAtAnLodWithoutError) {
  test::SyntheticModel model = deepModel();
  for (Node& node : model.nodes)
    if (node.key.depth() >= 2)
      for (Lod& lod : node.lods) lod.error_model = 0;
  const TilesOf tiles(std::move(model));
  tiles.forEachTile([](const Json& tile, double above, const std::string&) {
    EXPECT_LT(tile["geometricError"].get<double>(), above);
    EXPECT_EQ(tile["geometricError"] == 0, !tile.contains("children"));
  });
  for (const auto& [name, item] : tiles.items()) EXPECT_LE(tiles.reader().nodes()[item.node].key.depth(), 2);
}

TEST(TileNames, areMadeOfDigestsAndTheWritersVersion) {
  const TilesOf tiles(deepModel());
  for (const auto& [name, page] : tiles.pages()) {
    EXPECT_TRUE(name == "tileset.json" || std::regex_match(name, std::regex("p/[0-9a-f]{32}\\.json")))
        << name;
  }
  for (const auto& [name, item] : tiles.items()) {
    const Digest& digest = tiles.reader().nodes()[item.node].lods[item.lod].payload.digest;
    EXPECT_EQ(name, "g/" + toHex(digest) + ".2.glb");
  }
}

/// Returns the names of pages that both tilesets have with different bytes.
std::vector<std::string> changedUnderTheirName(const TilesOf& a, const TilesOf& b) {
  std::vector<std::string> names;
  for (const auto& [name, page] : a.pages())
    if (const auto other = b.pages().find(name); name != "tileset.json" && other != b.pages().end())
      if (page != other->second) names.push_back(name);
  return names;
}

TEST(TileNames, areOthersWhereTheContentIsAnother) {
  const TilesOf tiles(deepModel());
  // The same page below an ancestor with another error, and on another lattice.
  test::SyntheticModel closer = deepModel();
  const float error = closer.nodes.back().lods[0].error_model;
  for (Node& node : closer.nodes)
    if (!node.isLeaf())
      for (Lod& lod : node.lods) lod.error_model = error;
  EXPECT_EQ(changedUnderTheirName(tiles, TilesOf(std::move(closer))), std::vector<std::string>());
  EXPECT_EQ(changedUnderTheirName(tiles, TilesOf(deepModel({.lattice = {{}, 0.5}}))),
            std::vector<std::string>());
  // The same page below an owner with another box.
  test::SyntheticModel wider = deepModel();
  for (Node& node : wider.nodes) node.box = node.key.depth() <= 2 ? wider.nodes[0].box : node.box;
  EXPECT_EQ(changedUnderTheirName(tiles, TilesOf(std::move(wider))), std::vector<std::string>());
}

TEST(TileNames, areTheSameWhereTheContentIsTheSame) {
  const TilesOf tiles(deepModel()), moved(deepModel({.lattice = {{1000, 2000, 3000}, 0.25}}));
  std::set<std::string> names, names_of_moved;
  for (const auto& [name, page] : tiles.pages()) names.insert(name);
  for (const auto& [name, page] : moved.pages()) names_of_moved.insert(name);
  EXPECT_EQ(names, names_of_moved);
}

/// Returns the digest of all files of a tileset.
std::string digestOfFiles(const TilesOf& tiles) {
  std::string all;
  for (const auto& [name, page] : tiles.pages()) all += name + page.dump();
  for (const auto& [name, item] : tiles.items()) {
    const std::vector<std::byte> glb = tiles.writer().glb(item).bytes;
    all += name + toHex(digestOf(glb));
  }
  return toHex(digestOf(std::as_bytes(std::span(all))));
}

TEST(TileNames, haveAnotherVersionIfTheBytesChange) {
  // If this fails, raise kWriterVersion: caches keep files by name. Then update the digests.
  constexpr uint8_t kColours = AttributeSet::kNormal | AttributeSet::kColour;
  EXPECT_EQ(digestOfFiles(TilesOf(deepModel())), "8c3289f4947cca07e1ca85e39c35f4e0");
  EXPECT_EQ(digestOfFiles(TilesOf(test::makeModel(
                test::makeSphere(24, 16, {.attributes = {kColours}, .extent = 4000, .seed = 7})))),
            "220d76d46c6434a0e39905dde6bc6a2e");
}

/// Selects a random cut that a viewer could draw: descends from the root and stops at random tiles.
class RandomTiles {
 public:
  RandomTiles(const TilesOf& tiles, uint32_t seed) : tiles_(tiles), random_(seed), stop_of_16_(1 + seed % 8) {
    draw(tiles.root(), "tileset.json");
  }
  store::OpenEdges& edges() { return edges_; }
  uint64_t triangles() const { return triangles_; }

 private:
  void draw(const Json& tile, const std::string& page) {
    const std::string uri = tile.contains("content") ? tile["content"]["uri"] : "";
    const std::string name = TilesOf::resolve(page, uri);
    if (uri.ends_with(".json")) {
      for (const Json& child : tiles_.pages().at(name)["root"]["children"]) draw(child, name);
    } else if (!tile.contains("children") || random_() % 16 < stop_of_16_) {
      if (!uri.empty()) add(tiles_.items().at(name));
    } else {
      for (const Json& child : tile["children"]) draw(child, page);
    }
  }

  /// Adds a tile's triangles, decoded from its GLB as a viewer decodes them.
  void add(store::CutItem item) {
    const test::ViewedStream stream(test::parseGlb(tiles_.writer().glb(item).bytes));
    Mesh mesh;
    for (uint32_t v = 0; v < stream.mesh().num_points(); ++v) {
      const std::vector<float> p = stream.floats(0, v);
      mesh.positions.push_back(packPosition(glm::uvec3(p[0] * 4, p[1] * 4, p[2] * 4)));
    }
    for (draco::FaceIndex f(0); f < stream.mesh().num_faces(); ++f) {
      const auto face = stream.mesh().face(f);
      mesh.triangles.emplace_back(face[0].value(), face[1].value(), face[2].value());
    }
    triangles_ += mesh.triangles.size();
    edges_.add(mesh);
  }

  const TilesOf& tiles_;
  std::mt19937 random_;
  uint32_t stop_of_16_;
  store::OpenEdges edges_;
  uint64_t triangles_ = 0;
};

TEST(Tileset, isClosedInEveryMixtureOfTiles) {
  for (const uint8_t attributes : {uint8_t{0}, AttributeSet::kColour}) {
    const TilesOf tiles(
        test::makeModel(test::makeSphere(24, 16, {.attributes = {attributes}, .extent = 4000, .seed = 7})));
    std::set<uint64_t> mixtures;
    for (uint32_t seed = 0; seed < 24; ++seed) {
      RandomTiles drawn(tiles, seed);
      EXPECT_EQ(drawn.edges().edges().size(), 0u) << seed;
      mixtures.insert(drawn.triangles());
    }
    EXPECT_GT(mixtures.size(), 10u);
  }
}

}  // namespace
}  // namespace lode::tiles
