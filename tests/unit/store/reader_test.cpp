#include "server/store/reader.h"

#include <fcntl.h>
#include <unistd.h>

#include "server/store/format.h"
#include "server/store/verify.h"
#include "tests/unit/store/store_files.h"

namespace lode::store {
namespace {

using test::WorkFolder;

TEST(Reader, readsBackTheWrittenModel) {
  const WorkFolder folder;
  test::SyntheticModel model = test::closedModel();
  const ModelSummary written = test::writeStore(folder / "sphere.lode", model);
  const Reader reader(folder / "sphere.lode");
  EXPECT_EQ(reader.summary(), written);
  EXPECT_EQ(reader.summary().name, "sphere");
  EXPECT_EQ(reader.summary().bytes, std::filesystem::file_size(folder / "sphere.lode"));
  EXPECT_GE(reader.summary().depth, 3u);
  ASSERT_EQ(reader.nodes().size(), model.nodes.size());
  for (size_t i = 0; i < model.nodes.size(); ++i) {
    Node node = reader.nodes()[i];
    EXPECT_EQ(static_cast<bool>(node.child_page),
              node.key.depth() >= 2 && node.key.depth() % 2 == 0 && !node.isLeaf());
    node.child_page = {};
    EXPECT_EQ(node, model.nodes[i]);
  }
}

TEST(Reader, readsTheBytesOfEveryBlob) {
  const WorkFolder folder;
  test::SyntheticModel model = test::closedModel();
  test::writeStore(folder / "a.lode", model);
  const Reader reader(folder / "a.lode");
  uint64_t end = kHeaderBytes;
  for (uint32_t number = 1; number <= reader.blobCount(); ++number) {
    EXPECT_EQ(reader.blob(number).offset, end);
    EXPECT_EQ(digestOf(reader.readBlob(number)), reader.blob(number).digest);
    end += reader.blob(number).bytes;
  }
}

TEST(Reader, findsNodesByKeyAndOnlyThose) {
  const WorkFolder folder;
  test::SyntheticModel model = test::closedModel();
  test::writeStore(folder / "a.lode", model);
  const Reader reader(folder / "a.lode");
  for (const Node& node : reader.nodes()) {
    EXPECT_EQ(reader.find(node.key), &node);
    for (unsigned octant = 0; octant < 8; ++octant)
      EXPECT_EQ(reader.find(node.key.child(octant)) != nullptr, (node.child_mask >> octant & 1) != 0);
  }
}

TEST(Reader, refusesBlobNumbersThatDoNotExist) {
  const WorkFolder folder;
  test::SyntheticModel model = test::smallModel();
  test::writeStore(folder / "a.lode", model);
  const Reader reader(folder / "a.lode");
  EXPECT_THROW(reader.readBlob(0), Error);
  EXPECT_THROW(reader.readBlob(reader.blobCount() + 1), Error);
}

// Reader checks header, pages, blob table and footer; verifyStore() also checks payloads.
TEST(Reader, openingOrVerifyRejectsAStoreWithAnyByteChanged) {
  const WorkFolder folder;
  const auto path = folder / "a.lode";
  test::SyntheticModel model = test::smallModel();
  test::writeStore(path, model);
  const std::vector<char> bytes = test::readFile(path);
  const int file = ::open(path.c_str(), O_WRONLY);
  ASSERT_GE(file, 0);
  for (size_t i = 0; i < bytes.size(); ++i)
    for (const int mask : {0x01, 0x80, 0xff}) {
      const char changed = static_cast<char>(bytes[i] ^ mask);
      ASSERT_EQ(::pwrite(file, &changed, 1, static_cast<off_t>(i)), 1);
      EXPECT_THROW(verifyStore(path), Error) << "byte " << i << " of " << bytes.size();
      ASSERT_EQ(::pwrite(file, &bytes[i], 1, static_cast<off_t>(i)), 1);
    }
  ::close(file);
  EXPECT_NO_THROW(verifyStore(path));
}

TEST(Reader, rejectsAChangedPayloadWhenItIsRead) {
  const WorkFolder folder;
  const auto path = folder / "a.lode";
  test::SyntheticModel model = test::smallModel();
  test::writeStore(path, model);
  std::vector<char> bytes = test::readFile(path);
  bytes[kHeaderBytes + 20] ^= 1;  // the first payload follows the header
  test::writeFile(path, bytes);
  const Reader reader(path);
  EXPECT_NE(test::messageOf([&] { reader.readBlob(1); }).find("checksum"), std::string::npos);
  EXPECT_NO_THROW(reader.readBlob(2));
}

TEST(Reader, rejectsAStoreTruncatedAtAnyLength) {
  const WorkFolder folder;
  const auto path = folder / "a.lode";
  test::SyntheticModel model = test::smallModel();
  test::writeStore(path, model);
  for (uint64_t length = std::filesystem::file_size(path); length-- > 0;) {
    std::filesystem::resize_file(path, length);
    EXPECT_THROW(Reader{path}, Error) << length;
  }
}

TEST(Reader, rejectsBytesBehindTheEnd) {
  const WorkFolder folder;
  const auto path = folder / "a.lode";
  test::SyntheticModel model = test::smallModel();
  test::writeStore(path, model);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) + 1);
  EXPECT_NE(test::messageOf([&] { Reader{path}; }).find("extra bytes"), std::string::npos);
}

TEST(Reader, namesFileAndRemedyIfAFileIsNoStore) {
  const WorkFolder folder;
  const auto complain = [&](const std::string& name) {
    const std::string message = test::messageOf([&] { Reader{folder / name}; });
    EXPECT_NE(message.find((folder / name).string()), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
    return message;
  };
  EXPECT_NE(complain("missing.lode").find("No such file"), std::string::npos);
  std::filesystem::create_directory(folder / "folder.lode");
  EXPECT_NE(complain("folder.lode").find("directory"), std::string::npos);
  test::writeFile(folder / "empty.lode", {});
  EXPECT_NE(complain("empty.lode").find("empty"), std::string::npos);
  test::writeFile(folder / "other.lode", std::vector<char>(4096, 'x'));
  EXPECT_NE(complain("other.lode").find("is not a store"), std::string::npos);
  test::writeFile(folder / "short.lode", std::vector<char>(9, 'x'));
  EXPECT_NE(complain("short.lode").find("is not a store"), std::string::npos);
  test::writeFile(folder / "cut.lode", std::vector<char>{'L', 'O', 'D', 'E', '\r', '\n', '\x1a', '\n', 4});
  EXPECT_NE(complain("cut.lode").find("truncated: it has only 9 bytes"), std::string::npos);
  test::writeFile(folder / "a.obj", std::vector<char>{'v', ' ', '1', '\n'});
  EXPECT_NE(complain("a.obj").find("is an OBJ, neither a PLY file nor a store"), std::string::npos);
}

TEST(Reader, reportsTheEndOfAFileTruncatedAfterOpening) {
  const WorkFolder folder;
  const auto path = folder / "a.lode";
  test::SyntheticModel model = test::smallModel();
  test::writeStore(path, model);
  const Reader reader(path);
  const uint64_t end = reader.blob(2).offset + 1;
  std::filesystem::resize_file(path, end);
  EXPECT_NE(test::messageOf([&] { reader.readBlob(2); }).find("ends at byte " + std::to_string(end)),
            std::string::npos);
  EXPECT_NO_THROW(reader.readBlob(1));
}

}  // namespace
}  // namespace lode::store
