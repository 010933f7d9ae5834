#include "server/store/writer.h"

#include "common/limits.h"
#include "server/store/reader.h"
#include "tests/unit/store/store_files.h"

namespace lode::store {
namespace {

using test::WorkFolder;

size_t filesIn(const WorkFolder& folder) {
  return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder.path()), {}));
}

TEST(Writer, givesEqualBytesTheSameBlob) {
  const WorkFolder folder;
  Writer writer(folder / "a.lode");
  const std::vector<std::byte> a(100, std::byte{1}), b(100, std::byte{2});
  const BlobRef first = writer.addBlob(a);
  EXPECT_EQ(first.number, 1u);
  EXPECT_EQ(writer.addBlob(b).number, 2u);
  EXPECT_EQ(writer.addBlob(a), first);
}

TEST(Writer, givesNoBytesNoBlob) {
  const WorkFolder folder;
  Writer writer(folder / "a.lode");
  EXPECT_FALSE(writer.addBlob({}));
}

TEST(Writer, leavesNothingBehindWhenItIsNotFinished) {
  const WorkFolder folder;
  {
    Writer writer(folder / "a.lode");
    writer.addBlob(std::vector<std::byte>(1 << 20, std::byte{1}));
  }
  EXPECT_EQ(filesIn(folder), 0u);
}

TEST(Writer, leavesTheOldStoreInPlaceWhenTheNewOneFails) {
  const WorkFolder folder;
  test::SyntheticModel model = test::smallModel();
  test::writeStore(folder / "a.lode", model);
  const auto before = test::readFile(folder / "a.lode");
  test::SyntheticModel bad = test::smallModel();
  bad.nodes.pop_back();
  EXPECT_THROW(test::writeStore(folder / "a.lode", bad), Error);
  EXPECT_EQ(filesIn(folder), 1u);
  EXPECT_EQ(test::readFile(folder / "a.lode"), before);
}

TEST(Writer, saysWhereItCannotWrite) {
  const WorkFolder folder;
  const std::string message = test::messageOf([&] { Writer{folder / "missing" / "a.lode"}; });
  EXPECT_NE(message.find("missing"), std::string::npos);
}

TEST(Writer, writesTheSameBytesForTheSameModel) {
  const WorkFolder folder;
  for (const char* name : {"a.lode", "b.lode"}) {
    test::SyntheticModel model = test::closedModel();
    test::writeStore(folder / name, model);
  }
  EXPECT_EQ(test::readFile(folder / "a.lode"), test::readFile(folder / "b.lode"));
}

TEST(Writer, changesTheBuildIdWithAnythingInTheStore) {
  const WorkFolder folder;
  test::SyntheticModel a = test::smallModel(), b = test::smallModel(), c = test::smallModel();
  b.nodes.back().lods[0].error_model *= 0.5f;
  c.summary.dropped = 1;
  const Digest id = test::writeStore(folder / "a.lode", a).build_id;
  EXPECT_NE(test::writeStore(folder / "b.lode", b).build_id, id);
  EXPECT_NE(test::writeStore(folder / "c.lode", c).build_id, id);
}

TEST(Writer, countsTheTotalsOfTheSummary) {
  const WorkFolder folder;
  test::SyntheticModel model = test::closedModel();
  const ModelSummary summary = test::writeStore(folder / "a.lode", model);
  EXPECT_EQ(summary.triangles, 2u * 24 * 15);
  EXPECT_EQ(summary.nodes, model.nodes.size());
  EXPECT_EQ(summary.box, model.nodes[0].box);
  EXPECT_EQ(summary.max_error_model, model.nodes[0].lods.back().error_model);
  EXPECT_TRUE(summary.root_page);
}

TEST(Writer, refusesBlobsThatNoLodUses) {
  const WorkFolder folder;
  test::SyntheticModel model = test::smallModel();
  Writer writer(folder / "a.lode");
  writer.addBlob(std::vector<std::byte>(10, std::byte{7}));
  for (Node& node : model.nodes)
    for (uint32_t i = 0; i < node.lods.size(); ++i) {
      const auto payload = encodePayload(model.meshes.at({node.key, i}), model.summary.lattice.step);
      node.lods[i].payload = writer.addBlob(payload.bytes);
    }
  EXPECT_THROW(writer.finish(model.summary, model.nodes), Error);
}

TEST(Writer, refusesTilesThatWereNotAdded) {
  const WorkFolder folder;
  test::SyntheticModel model = test::smallModel();
  EXPECT_THROW(test::writeStore(folder / "a.lode", model,
                                [](Writer& writer) {
                                  TextureSet set;
                                  set.textures = {test::addFakeTexture(writer, "x", 600, 1)};
                                  ++set.textures[0].tiles[1].bytes;
                                  return set;
                                }),
               Error);
}

TEST(Writer, refusesTilesThatTheSetDoesNotName) {
  const WorkFolder folder;
  test::SyntheticModel model = test::smallModel();
  EXPECT_THROW(test::writeStore(folder / "a.lode", model,
                                [](Writer& writer) {
                                  test::addFakeTexture(writer, "x", 600, 1);
                                  return TextureSet();
                                }),
               Error);
}

TEST(Writer, refusesNodesThatHaveAPageAlready) {
  const WorkFolder folder;
  test::SyntheticModel model = test::smallModel();
  model.nodes[0].child_page = {1, 1, {}};
  EXPECT_NE(test::messageOf([&] { test::writeStore(folder / "a.lode", model); }).find("has a page already"),
            std::string::npos);
}

TEST(Writer, refusesPayloadsThatWereNotAdded) {
  const WorkFolder folder;
  test::SyntheticModel model = test::smallModel();
  test::writeStore(folder / "a.lode", model);
  Writer writer(folder / "b.lode");
  EXPECT_THROW(writer.finish(model.summary, model.nodes), Error);
}

}  // namespace
}  // namespace lode::store
