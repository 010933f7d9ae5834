#include "server/ingest/nodes/simplify_log.h"

#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/disk/synced_files.h"

namespace lode::ingest {
namespace {

/// A killed build's log: one finished subtree whose parent is unfinished.
class KilledBuild : public testing::Test {
 protected:
  void SetUp() override {
    PayloadSpool payloads(files_);
    SimplifyLog log(files_, payloads, {}, append());
    built_.node = leaf(kChild);
    built_.payloads.resize(1);
    built_.original_triangles = 123;
    note(log, built_.node);
    log.addRoot(built_);
    log.write();
  }

  SimplifyLog::Append append() {
    return [this](std::span<const std::byte> entry) { entries_.emplace_back(entry.begin(), entry.end()); };
  }

  static Node leaf(NodeKey key) {
    Node node;
    node.key = key;
    node.lods.resize(1);
    return node;
  }

  static void note(SimplifyLog& log, const Node& node) {
    RecordWriter record;
    putFinishedNode(record, node, std::vector<PayloadSpool::Place>(1));
    log.addFinished(record.bytes());
  }

  FinishedNodes finished() const {
    FinishedNodes nodes;
    for (const std::vector<std::byte>& entry : entries_) {
      RecordReader record(entry);
      nodes.add(record);
    }
    return nodes;
  }

  uint64_t trianglesBelow(NodeKey key) const {
    PayloadSpool payloads(files_, 0);
    return SimplifyLog(files_, payloads, finished(), {}).readRoot(key).original_triangles;
  }

  static constexpr NodeKey kChild = kRootKey.child(3);

  test::WorkFolder folder_;
  const TemporaryFolder files_ = TemporaryFolder::lasting(folder_ / "files");
  BuiltNode built_;
  std::vector<std::vector<std::byte>> entries_;
};

TEST_F(KilledBuild, restoresTheDataOfAFinishedSubtreeForItsParent) {
  EXPECT_EQ(trianglesBelow(kChild), 123u);
}

TEST_F(KilledBuild, isRefusedIfASavedSubtreeIsDamaged) {
  const auto path = folder_ / "files" / SimplifyLog::kRootFile;
  std::ifstream in(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  bytes.at(bytes.rfind(char{123})) = 124;  // the changed record remains readable
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_THROW(trianglesBelow(kChild), Error);
}

TEST_F(KilledBuild, isRefusedIfASubtreeLiesBeyondTheEndOfItsFile) {
  struct Root {
    NodeKey key;
    FinishedNodes::Place place;
  };
  RecordWriter entry;
  entry.put(uint64_t{0});  // payload bytes
  entry.put(uint64_t{8});  // subtree bytes
  entry.putAll(std::vector{Root{kChild, {8, 8, 0}}});
  entry.put(uint32_t{0});  // finished nodes
  entries_.emplace_back(entry.bytes().begin(), entry.bytes().end());
  EXPECT_THROW(finished(), Error);
}

// After a power loss, the journal remains, but other files keep only their synced bytes.
TEST_F(KilledBuild, journalsOnlySyncedFiles) {
  const test::SyncedFiles synced;
  std::set<std::string, std::less<>> before_the_entry;
  PayloadSpool payloads(files_);
  SimplifyLog log(files_, payloads, {},
                  [&](std::span<const std::byte>) { before_the_entry = synced.names(); });
  note(log, built_.node);
  log.addRoot(built_);
  log.write();
  EXPECT_TRUE(before_the_entry.contains(PayloadSpool::kFile));
  EXPECT_TRUE(before_the_entry.contains(SimplifyLog::kRootFile));
}

TEST_F(KilledBuild, needsNoSubtreeOnceItsParentIsFinished) {
  EXPECT_TRUE(finished().roots.contains(kChild));
  entries_.clear();
  PayloadSpool payloads(files_);
  SimplifyLog log(files_, payloads, {}, append());
  const auto write = [&](NodeKey key, uint8_t child_mask) {
    Node node = leaf(key);
    node.child_mask = child_mask;
    note(log, node);
    log.write();
  };
  log.addRoot(built_);
  write(kChild, 0);
  write(kRootKey, 1 << 3);
  write(kRootKey.child(5), 0);
  EXPECT_TRUE(finished().roots.empty());
}

}  // namespace
}  // namespace lode::ingest
