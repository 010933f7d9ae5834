#include "server/tiles/tile_export.h"

#include <map>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/tiles/tile_writer.h"
#include "tests/support/bytes.h"
#include "tests/support/synthetic_store.h"

namespace lode::tiles {
namespace {

class TileExport : public testing::Test {
 protected:
  TileExport() {
    test::SyntheticModel model =
        test::makeModel(test::makeSphere(48, 32, {.attributes = {AttributeSet::kColour}, .extent = 4000}));
    test::writeStore(folder_ / "m.lode", model);
  }

  TileExportReport write(const std::string& name, unsigned threads, const TileExportProgress& progress) {
    return exportTiles(store::Reader(folder_ / "m.lode"), {.folder = folder_ / name, .threads = threads},
                       progress);
  }
  TileExportReport write(const std::string& name, unsigned threads = 1) {
    return write(name, threads, [](uint64_t, uint64_t) {});
  }

  /// Returns the bytes of all files in a folder.
  std::map<std::string, std::string> files(const std::string& name) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / name))
      if (entry.is_regular_file())
        files[std::filesystem::relative(entry.path(), folder_ / name)] = test::readBytes(entry.path());
    return files;
  }

  test::WorkFolder folder_;
};

TEST_F(TileExport, writesTheSameFilesWithAnyNumberOfThreads) {
  write("one");
  write("again");
  write("five", 5);
  EXPECT_EQ(files("again"), files("one"));
  EXPECT_EQ(files("five"), files("one"));
}

TEST_F(TileExport, writesTheFilesOfTheWriter) {
  write("tiles");
  std::map<std::string, std::string> wanted;
  const store::Reader reader(folder_ / "m.lode");
  const TileWriter writer(reader, glm::dmat4(1));
  std::vector<NodeKey> todo{kRootKey};
  while (!todo.empty()) {
    const NodeKey owner = todo.back();
    todo.pop_back();
    const TilesetPage page = writer.page(owner);
    wanted[writer.pageName(owner)] = page.json;
    for (const store::CutItem item : page.contents) {
      const std::vector<std::byte> glb = writer.glb(item).bytes;
      wanted[writer.glbName(item)] = {reinterpret_cast<const char*>(glb.data()), glb.size()};
    }
    todo.insert(todo.end(), page.pages.begin(), page.pages.end());
  }
  EXPECT_EQ(files("tiles"), wanted);
}

TEST_F(TileExport, reportsWhatItWrites) {
  const TileExportReport report = write("tiles", 2);
  uint64_t json_bytes = 0, glb_bytes = 0, pages = 0, glbs = 0;
  for (const auto& [name, bytes] : files("tiles")) {
    const bool is_page = name.ends_with(".json");
    (is_page ? json_bytes : glb_bytes) += bytes.size();
    ++(is_page ? pages : glbs);
  }
  EXPECT_EQ(report.pages, pages);
  EXPECT_EQ(report.glbs, glbs);
  EXPECT_EQ(report.json_bytes, json_bytes);
  EXPECT_EQ(report.glb_bytes, glb_bytes);
  EXPECT_GE(report.tiles, glbs);
}

TEST_F(TileExport, tellsItsProgress) {
  uint64_t last = 0, of = 0, calls = 0;
  const TileExportReport report = write("tiles", 1, [&](uint64_t done, uint64_t total) {
    EXPECT_EQ(done, std::min(calls, total));
    last = done;
    of = total;
    ++calls;
  });
  EXPECT_EQ(last, report.glbs);
  EXPECT_EQ(of, report.glbs);
}

TEST_F(TileExport, leavesNothingIfItIsInterrupted) {
  const auto interrupt = [](uint64_t done, uint64_t) {
    if (done > 3) throw Error(ErrorCode::kIo, "interrupted");
  };
  for (const unsigned threads : {1u, 4u}) EXPECT_THROW(write("tiles", threads, interrupt), Error);
  EXPECT_EQ(folder_.contents(), std::vector<std::string>{"m.lode"});
}

TEST_F(TileExport, leavesNothingIfThePayloadIsDamaged) {
  std::string bytes = test::readBytes(folder_ / "m.lode");
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(folder_ / "m.lode", std::ios::binary) << bytes;
  EXPECT_THROW(write("tiles", 3), Error);
  EXPECT_EQ(folder_.contents(), std::vector<std::string>{"m.lode"});
}

TEST_F(TileExport, writesEqualPayloadsOnce) {
  test::SyntheticModel model =
      test::makeModel(test::makeSphere(5, 4, {.attributes = {}, .extent = 4000}), {.leaf_triangles = 1000});
  Node& root = model.nodes[0];
  model.meshes[{kRootKey, 1}] = model.meshes[{kRootKey, 0}];
  root.lods.push_back(root.lods[0]);
  root.lods[1].error_model *= 3;
  test::writeStore(folder_ / "m.lode", model);
  const TileExportReport report = write("tiles", 4);
  EXPECT_EQ(report.tiles, 2u);
  EXPECT_EQ(report.glbs, 1u);
}

}  // namespace
}  // namespace lode::tiles
