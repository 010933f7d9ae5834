// Texture sets in stores: that they come back, and what a hostile one is refused for.

#include <cstring>

#include "server/store/format.h"
#include "server/store/reader.h"
#include "server/store/verify.h"
#include "tests/unit/store/store_files.h"

namespace lode::store {
namespace {

class StoredTextures : public testing::Test {
 protected:
  ModelSummary write(const std::function<TextureSet(Writer&)>& add) {
    test::SyntheticModel model = test::smallModel();
    return test::writeStore(path_, model, add);
  }

  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "a.lode";
};

TextureSet twoTextures(Writer& writer) {
  TextureSet set;
  set.uv_scale_exponent = 2;
  set.textures = {test::addFakeTexture(writer, "bark 1.png", 600, 300), Texture{"missing.png", 0, 0, {}},
                  test::addFakeTexture(writer, "leaf", 8, 8)};
  return set;
}

TEST_F(StoredTextures, comeBackWithTheStore) {
  TextureSet written;
  const ModelSummary summary = write([&](Writer& writer) { return written = twoTextures(writer); });
  const Reader reader(path_);
  EXPECT_EQ(reader.textures(), written);
  EXPECT_EQ(reader.summary(), summary);
  EXPECT_EQ(decodeTextureSet(reader.readBlob(summary.textures.number)), written);
}

TEST_F(StoredTextures, areAbsentFromAStoreWithoutThem) {
  EXPECT_FALSE(write({}).textures);
  EXPECT_EQ(Reader(path_).textures(), TextureSet());
}

TEST_F(StoredTextures, mayShareTiles) {
  write([](Writer& writer) {
    TextureSet set;
    set.textures = {test::addFakeTexture(writer, "same", 600, 300),
                    test::addFakeTexture(writer, "same", 600, 300)};
    return set;
  });
  const Reader reader(path_);
  EXPECT_EQ(reader.textures().textures[0].tiles, reader.textures().textures[1].tiles);
}

TEST_F(StoredTextures, whoseTilesAreNotThoseOfTheTableAreRefused) {
  const ModelSummary summary = write(twoTextures);
  // The set is rewritten in place, with the checksums of everything above it.
  std::vector<char> file = test::readFile(path_);
  uint64_t at = 0;
  std::vector<std::byte> blob;
  {
    const Reader reader(path_);
    at = reader.blob(summary.textures.number).offset;
    blob = reader.readBlob(summary.textures.number);
  }
  blob[blob.size() - 1] ^= std::byte{1};  // of the last tile's name
  std::memcpy(&file[at], blob.data(), blob.size());
  const std::span<std::byte> bytes = std::as_writable_bytes(std::span(file));
  FileHeader header = decodeHeader(bytes.first<kHeaderBytes>(), bytes.size());
  const auto table_bytes = bytes.subspan(header.table_offset, header.blobs * kTableEntryBytes);
  std::vector<TableEntry> table = decodeTable(table_bytes, header);
  table[summary.textures.number - 1].checksum = checksum(blob);
  table[summary.textures.number - 1].name = nameBlob(blob);
  const std::vector<std::byte> new_table = encodeTable(table);
  std::copy(new_table.begin(), new_table.end(), table_bytes.begin());
  header.table_checksum = checksum(new_table);
  header.summary.build_id = computeBuildId(header, new_table);
  const auto new_header = encodeHeader(header);
  std::copy(new_header.begin(), new_header.end(), bytes.begin());
  const auto footer = encodeFooter(new_header);
  std::copy(footer.begin(), footer.end(), bytes.end() - kFooterBytes);
  test::writeFile(path_, file);
  EXPECT_NE(test::messageOf([&] { Reader reader(path_); }).find("texture leaf: size or name"),
            std::string::npos);
}

TEST_F(StoredTextures, ofTheFormatBeforeThemAreToBeBuiltAgain) {
  write({});
  std::vector<char> file = test::readFile(path_);
  file[8] = 1;
  test::writeFile(path_, file);
  EXPECT_NE(test::messageOf([&] { Reader reader(path_); }).find("build it again"), std::string::npos);
}

}  // namespace
}  // namespace lode::store
