#include "server/http/tileset.h"

#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "common/up_axis.h"
#include "server/store/export.h"
#include "server/tiles/tile_export.h"
#include "server/tiles/tile_frame.h"
#include "tests/support/bytes.h"
#include "tests/support/synthetic_store.h"
#include "tests/unit/tiles/textured_store.h"

namespace lode::http {
namespace {

class TilesetTest : public testing::Test {
 protected:
  TilesetTest() {
    test::SyntheticModel model =
        test::makeModel(test::makeSphere(96, 64, {.attributes = {AttributeSet::kColour}, .extent = 4000}));
    test::writeStore(folder_ / "m.lode", model);
    store_ = std::make_shared<const store::Reader>(folder_ / "m.lode");
  }

  /// Returns the bytes of all files that export writes, by name.
  std::map<std::string, std::string> exported() const {
    const Node& root = store_->nodes().front();
    const auto coarsest = static_cast<uint32_t>(root.lods.size() - 1);
    const glm::dvec3 up = guessUp(store::readLod(*store_, root, coarsest));
    tiles::exportTiles(
        *store_, {.folder = folder_ / "x", .root_transform = tiles::rootTransform(store_->summary(), up, {})},
        [](uint64_t, uint64_t) {});
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "x"))
      if (entry.is_regular_file())
        files[std::filesystem::relative(entry.path(), folder_ / "x")] = test::readBytes(entry.path());
    return files;
  }

  static void expectMade(const Tileset& tileset, const std::map<std::string, std::string>& files) {
    for (const auto& [name, bytes] : files) {
      ASSERT_TRUE(tileset.has(name)) << name;
      const std::unique_ptr<const Content> made = tileset.make(name);
      const auto& file = static_cast<const FileContent&>(*made);
      EXPECT_EQ(std::string(reinterpret_cast<const char*>(file.plain().data()), file.plain().size()), bytes)
          << name;
      EXPECT_EQ(file.packed().empty(), !name.ends_with(".json")) << name;
    }
  }

  test::WorkFolder folder_;
  std::shared_ptr<const store::Reader> store_;
};

TEST_F(TilesetTest, makesEveryFileOfTheExport) {
  const Tileset tileset(store_);
  const auto files = exported();
  EXPECT_GT(files.size(), 20u);
  expectMade(tileset, files);
}

TEST_F(TilesetTest, makesTheImagesThatTilesShare) {
  const test::TextureImages image(700, 300, test::texelAt);
  test::SyntheticModel model = test::makeModel(test::makeSphere(
      24, 16, {.attributes = {AttributeSet::kTexture | AttributeSet::kMaterial}, .extent = 4000}));
  const test::TexturedStore textured({image, image}, 3, std::move(model));
  store_ = std::make_shared<const store::Reader>(textured.reader().path());
  const Tileset tileset(store_);
  const auto files = exported();
  EXPECT_GT(std::ranges::count_if(files, [](const auto& file) { return file.first.starts_with("i/"); }), 0);
  expectMade(tileset, files);
}

TEST_F(TilesetTest, hasNoOtherFiles) {
  const Tileset tileset(store_);
  const std::string hex = toHex(store_->nodes().front().lods.front().payload.digest);
  for (const std::string& name :
       {std::string("g/") + std::string(32, '0') + ".2.glb", "p/" + hex + ".json", "g/" + hex + ".1.glb",
        "g/" + hex, std::string("p/"), std::string("models.json")})
    EXPECT_FALSE(tileset.has(name)) << name;
}

}  // namespace
}  // namespace lode::http
