// Reads that opening a store takes. On network storage each of them costs a round trip.

#include <array>
#include <cstring>
#include <fstream>
#include <optional>
#include <set>
#include <string>

#include "common/limits.h"
#include "server/store/reader.h"
#include "tests/unit/store/store_files.h"

namespace lode::store {
namespace {

/// Returns the number of read calls of this process, or nothing if the system does not count them.
std::optional<uint64_t> readCalls() {
  std::ifstream counters("/proc/self/io");
  std::string name;
  for (uint64_t value = 0; counters >> name >> value;)
    if (name == "syscr:") return value;
  return std::nullopt;
}

/// Returns the number of read calls of an action.
template <typename Action>
uint64_t readCallsOf(Action&& action) {
  const uint64_t first = *readCalls();
  const uint64_t own = *readCalls() - first;  // each readCalls() itself reads
  const uint64_t before = *readCalls();
  action();
  return *readCalls() - before - own;
}

/// Writes a store whose inner nodes have four children each, like the octree of a surface. Its payloads are
/// no meshes, because opening reads none of them.
void writeSurfaceLikeStore(const std::filesystem::path& path, int depth) {
  Writer writer(path);
  std::vector<Node> nodes;
  std::vector<NodeKey> level{kRootKey};
  for (int at = 0; at <= depth; ++at) {
    std::vector<NodeKey> below;
    for (const NodeKey key : level) {
      std::array<std::byte, sizeof key.value> payload{};
      std::memcpy(payload.data(), &key.value, payload.size());
      Node node;
      node.key = key;
      node.box = {glm::uvec3(0), glm::uvec3(1000)};
      node.child_mask = at < depth ? 0x0f : 0;
      Lod lod;
      lod.payload = writer.addBlob(payload);
      lod.triangles = 1;
      lod.vertices = 3;
      lod.error_model = static_cast<float>(depth - at);
      node.lods.push_back(lod);
      nodes.push_back(node);
      if (at < depth)
        for (unsigned octant = 0; octant < 4; ++octant) below.push_back(key.child(octant));
    }
    level = std::move(below);
  }
  ModelSummary summary;
  summary.lattice = test::SyntheticOptions().lattice;
  writer.finish(summary, std::move(nodes));
}

class OpeningReads : public testing::Test {
 protected:
  void SetUp() override {
    if (!readCalls()) GTEST_SKIP() << "this system does not count reads in /proc/self/io";
  }

  /// Returns the reads that opening takes. Sets the fields below.
  uint64_t open(const std::filesystem::path& path) {
    std::optional<Reader> reader;
    const uint64_t reads = readCallsOf([&] { reader.emplace(path); });
    std::set<int> depths;
    page_bytes_ = reader->summary().root_page.bytes;
    for (const Node& node : reader->nodes())
      if (node.child_page) {
        page_bytes_ += node.child_page.bytes;
        depths.insert(node.key.depth());
      }
    page_levels_ = 1 + depths.size();
    pages_ = 1;
    for (const Node& node : reader->nodes()) pages_ += node.child_page ? 1 : 0;
    return reads;
  }

  const test::WorkFolder folder_;
  uint64_t pages_ = 0, page_bytes_ = 0, page_levels_ = 0;
};

TEST_F(OpeningReads, areOneForTheHeaderOneForTheTableAndOneForEachLevelOfPages) {
  test::SyntheticModel model = test::closedModel();
  test::writeStore(folder_ / "a.lode", model);
  const uint64_t reads = open(folder_ / "a.lode");
  ASSERT_GT(pages_, page_levels_);
  EXPECT_EQ(reads, 2 + page_levels_);
}

TEST_F(OpeningReads, areOneMoreForATextureSet) {
  test::SyntheticModel model = test::closedModel();
  test::writeStore(folder_ / "a.lode", model, [](Writer& writer) {
    TextureSet set;
    set.textures = {test::addFakeTexture(writer, "x", 600, 600)};
    return set;
  });
  const uint64_t reads = open(folder_ / "a.lode");
  EXPECT_EQ(reads, 2 + page_levels_ + 1);
}

// 87,381 nodes, as many as about 250 million triangles have.
TEST_F(OpeningReads, ofManyPagesFetchFourMegabytesEach) {
  writeSurfaceLikeStore(folder_ / "a.lode", 8);
  const uint64_t reads = open(folder_ / "a.lode");
  constexpr uint64_t kRunBytes = (4u << 20) - kMaxPageBytes;
  ASSERT_GT(page_bytes_, kRunBytes);
  ASSERT_GT(pages_, 4000u);
  EXPECT_LE(reads, 2 + page_levels_ + page_bytes_ / kRunBytes);
}

}  // namespace
}  // namespace lode::store
