#include "server/ingest/nodes/treelet_file.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/nodes/built_tree.h"
#include "server/ingest/nodes/treelet_folder.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/nodes/leaves.h"

namespace lode::ingest {
namespace {

using lode::test::readBytes;

void writeText(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

BuiltNode builtNode(NodeKey key, size_t lods) {
  BuiltNode built;
  built.node.key = key;
  for (size_t lod = 0; lod < lods; ++lod) {
    built.node.lods.emplace_back().triangles = static_cast<uint32_t>(100 - lod);
    built.payloads.emplace_back(10 * lod + 1, std::byte(static_cast<uint8_t>(key.value + lod)));
  }
  built.coarsest.positions = {packPosition({0, 0, 0}), packPosition({9, 0, 0}), packPosition({0, 9, 0})};
  built.coarsest.triangles = {{0, 1, 2}};
  built.original_triangles = 1234;
  return built;
}

/// Writes a treelet of two nodes.
TreeletFile write(TreeletWriter writer) {
  const BuiltNode child = builtNode(kRootKey.child(3), 1), root = builtNode(kRootKey, 3);
  writer.add(child.node, child.payloads);
  writer.add(root.node, root.payloads);
  return writer.finish(root);
}

void expectBothNodes(const TreeletFile& file) {
  BuiltTree tree;
  tree.add(file);
  ASSERT_EQ(tree.size(), 2u);
  for (const BuiltTree::Place& place : tree.sorted()) {
    const BuiltNode expected = builtNode(place.key, place.key == kRootKey ? 3 : 1);
    const FinishedNode found = tree.read(place);
    EXPECT_EQ(found.node, expected.node);
    ASSERT_EQ(found.payloads.size(), expected.payloads.size());
    for (size_t lod = 0; lod < found.payloads.size(); ++lod)
      EXPECT_EQ(tree.readPayload(place, found.payloads[lod]), expected.payloads[lod]);
  }
  EXPECT_EQ(tree.sorted().front().key, kRootKey);
  EXPECT_EQ(file.rootTriangles(), 1u);
  EXPECT_EQ(file.readRoot().original_triangles, 1234u);
}

class OneTreelet : public testing::Test {
 protected:
  lode::test::WorkFolder folder_;
  const std::filesystem::path path_ = folder_ / "treelet";
};

TEST_F(OneTreelet, isReadBackWithNodesPayloadsAndRoot) {
  expectBothNodes(write(TreeletWriter(path_)));
  const std::optional<TreeletFile> opened = TreeletFile::open(path_);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->bytes(), std::filesystem::file_size(path_));
  expectBothNodes(*opened);
}

TEST_F(OneTreelet, hasItsNameOnlyOnceItIsFinished) {
  {
    TreeletWriter writer(path_);
    const BuiltNode root = builtNode(kRootKey, 1);
    writer.add(root.node, root.payloads);
    EXPECT_FALSE(std::filesystem::exists(path_));
  }
  EXPECT_TRUE(folder_.contents().empty()) << "an abandoned treelet leaves no file";
}

TEST_F(OneTreelet, isNotOpenedIfAnyByteHasChanged) {
  write(TreeletWriter(path_));
  const std::string sound = readBytes(path_);
  for (size_t at = 0; at < sound.size(); ++at) {
    std::string damaged = sound;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    writeText(path_, damaged);
    EXPECT_FALSE(TreeletFile::open(path_)) << at;
  }
}

TEST_F(OneTreelet, isNotOpenedIfItIsShorter) {
  write(TreeletWriter(path_));
  const std::string sound = readBytes(path_);
  for (size_t bytes = 0; bytes < sound.size(); ++bytes) {
    writeText(path_, sound.substr(0, bytes));
    EXPECT_FALSE(TreeletFile::open(path_)) << bytes;
  }
}

TEST_F(OneTreelet, canBeWrittenTwiceAtTheSameTime) {
  const BuiltNode root = builtNode(kRootKey, 1);
  TreeletWriter first(path_);
  first.add(root.node, root.payloads);
  write(TreeletWriter(folder_ / "other"));
  std::filesystem::rename(folder_ / "other", path_);  // another machine finishes it first
  first.finish(root);
  EXPECT_TRUE(TreeletFile::open(path_));
}

class SharedTreelets : public testing::Test {
 protected:
  lode::test::WorkFolder folder_;
  const std::filesystem::path shared_ = folder_ / "shared";
  const Digest name_ = test::digest("a treelet");

  TreeletFolder build(std::string_view own) const { return {folder_ / own, shared_}; }
};

TEST_F(SharedTreelets, areTakenFromTheSharedFolder) {
  const TreeletFolder first = build("first"), second = build("second");
  EXPECT_FALSE(second.find(name_));
  write(first.create(name_));
  EXPECT_TRUE(first.has(name_));
  EXPECT_FALSE(second.find(name_)) << "not shared yet";
  first.share(name_);
  const std::optional<TreeletFile> found = second.find(name_);
  ASSERT_TRUE(found);
  EXPECT_TRUE(second.has(name_));
  std::filesystem::remove_all(shared_);
  expectBothNodes(*found);
}

TEST_F(SharedTreelets, areRemovedFromBothFoldersIfDamaged) {
  const TreeletFolder first = build("first"), second = build("second");
  write(first.create(name_));
  first.share(name_);
  writeText(shared_ / "treelets" / (toHex(name_) + ".treelet"), "damaged");
  EXPECT_FALSE(second.find(name_));
  EXPECT_FALSE(second.has(name_));
  EXPECT_TRUE(std::filesystem::is_empty(shared_ / "treelets"));
}

TEST_F(SharedTreelets, areSharedByCopyBetweenFileSystems) {
  if (!std::filesystem::exists("/dev/shm")) GTEST_SKIP() << "no second file system";
  const std::filesystem::path other = "/dev/shm/lodestream-test-" + std::to_string(::getpid());
  {
    const TreeletFolder first(folder_ / "first", other), second(folder_ / "second", other);
    write(first.create(name_));
    first.share(name_);
    EXPECT_TRUE(second.find(name_));
  }
  std::filesystem::remove_all(other);
}

TEST_F(SharedTreelets, areTrimmedFromTheLongestUnused) {
  const TreeletFolder own = build("own");
  const auto now = std::filesystem::file_time_type::clock::now();
  std::vector<std::filesystem::path> files;
  for (const char* text : {"a", "b", "c"}) {
    write(own.create(test::digest(text)));
    own.share(test::digest(text));
    files.push_back(shared_ / "treelets" / (toHex(test::digest(text)) + ".treelet"));
    std::filesystem::last_write_time(files.back(), now - std::chrono::hours(10 - files.size()));
  }
  const std::string foreign = std::string(32, 'a') + ".jpg";
  writeText(shared_ / "treelets" / foreign, std::string(5000, 'x'));
  ASSERT_TRUE(build("reader").find(test::digest("a")));  // used again
  trimSharedTreelets(shared_, 2 * std::filesystem::file_size(files[0]));
  EXPECT_TRUE(std::filesystem::exists(files[0]));
  EXPECT_FALSE(std::filesystem::exists(files[1]));
  EXPECT_TRUE(std::filesystem::exists(files[2]));
  EXPECT_TRUE(std::filesystem::exists(shared_ / "treelets" / foreign));
  trimSharedTreelets(shared_, 0);
  EXPECT_FALSE(std::filesystem::exists(files[0]));
  EXPECT_TRUE(own.find(test::digest("b"))) << "builds keep what they use";
}

}  // namespace
}  // namespace lode::ingest
