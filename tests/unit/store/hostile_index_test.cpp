// Stores with valid checksums but invalid content, as an attacker can write them.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "common/limits.h"
#include "server/store/format.h"
#include "server/store/reader.h"
#include "server/store/verify.h"
#include "tests/unit/store/store_files.h"

namespace lode::store {
namespace {

/// Parts of a small store: a test changes them, then they are sealed with new checksums.
struct Parts {
  FileHeader header;
  std::vector<TableEntry> table;
  std::vector<std::byte> blobs;
};

class HostileIndex : public testing::Test {
 protected:
  void SetUp() override {
    test::SyntheticModel model = test::closedModel();
    test::writeStore(path_, model);
    const std::vector<char> file = test::readFile(path_);
    bytes_.resize(file.size());
    std::memcpy(bytes_.data(), file.data(), file.size());
  }

  Parts parts() const {
    Parts parts;
    const std::span<const std::byte> all(bytes_);
    parts.header = decodeHeader(all.first<kHeaderBytes>(), all.size());
    const uint64_t table_at = parts.header.table_offset;
    parts.table = decodeTable(all.subspan(table_at, parts.header.blobs * kTableEntryBytes), parts.header);
    parts.blobs.assign(all.begin() + kHeaderBytes, all.begin() + static_cast<ptrdiff_t>(table_at));
    return parts;
  }

  /// Opens the changed store. @return the reader's error message.
  std::string open(const std::function<void(Parts&)>& change, bool fresh_build_id = true) const {
    Parts changed = parts();
    changed.header.table_checksum = 0;
    change(changed);
    const std::vector<std::byte> table = encodeTable(changed.table);
    if (changed.header.table_checksum == 0) changed.header.table_checksum = checksum(table);
    if (fresh_build_id) changed.header.summary.build_id = computeBuildId(changed.header, table);
    const auto header = encodeHeader(changed.header);
    const auto footer = encodeFooter(header);
    std::vector<char> file;
    const auto append = [&](std::span<const std::byte> part) {
      const auto* data = reinterpret_cast<const char*>(part.data());
      file.insert(file.end(), data, data + part.size());
    };
    append(header);
    append(changed.blobs);
    append(table);
    append(footer);
    const auto path = folder_ / "hostile.lode";
    test::writeFile(path, file);
    return test::messageOf([&] { Reader{path}; });
  }

  /// Replaces a blob and everything that depends on its bytes, except pages that refer to it.
  static void replaceBlob(Parts& parts, uint32_t number, std::span<const std::byte> bytes) {
    size_t at = 0;
    for (uint32_t i = 0; i + 1 < number; ++i) at += parts.table[i].bytes;
    TableEntry& entry = parts.table[number - 1];
    const auto begin = parts.blobs.begin() + static_cast<ptrdiff_t>(at);
    parts.blobs.erase(begin, begin + entry.bytes);
    parts.blobs.insert(parts.blobs.begin() + static_cast<ptrdiff_t>(at), bytes.begin(), bytes.end());
    const uint64_t growth = bytes.size() - entry.bytes;
    parts.header.table_offset += growth;
    parts.header.summary.bytes += growth;
    entry = {static_cast<uint32_t>(bytes.size()), checksum(bytes), digestOf(bytes)};
  }

  /// Opens the store after changing the root's page.
  std::string openWithRootPage(const std::function<void(HierarchyPage&)>& change) const {
    return open([&](Parts& parts) {
      const uint32_t number = parts.header.summary.root_page.number;
      size_t at = 0;
      for (uint32_t i = 0; i + 1 < number; ++i) at += parts.table[i].bytes;
      const std::span<const std::byte> blob(&parts.blobs[at], parts.table[number - 1].bytes);
      HierarchyPage page = decodePage(blob, kRootKey, true);
      change(page);
      replaceBlob(parts, number, encodePage(page));
    });
  }

  test::WorkFolder folder_;
  std::filesystem::path path_ = folder_ / "good.lode";
  std::vector<std::byte> bytes_;
};

#define EXPECT_SAYS(message, words) \
  EXPECT_PRED2([](const std::string& m, const std::string& w) { return m.find(w) != m.npos; }, message, words)

TEST_F(HostileIndex, isAcceptedUnchanged) {
  EXPECT_EQ(open([](Parts&) {}), "");
  EXPECT_EQ(openWithRootPage([](HierarchyPage&) {}), "");
}

TEST_F(HostileIndex, pagesAreAcceptedInAnyOrder) {
  constexpr std::array<uint32_t, 9> kOrder{8, 7, 6, 5, 0, 4, 3, 2, 1};  // 0: the root's page
  const std::string message = open([&](Parts& parts) {
    const uint32_t root = parts.header.summary.root_page.number;
    ASSERT_EQ(parts.header.blobs, root + 8) << "the root's page and eight more come last";
    size_t pages_at = 0;
    for (uint32_t i = 0; i + 1 < root; ++i) pages_at += parts.table[i].bytes;
    std::vector<std::vector<std::byte>> pages;
    size_t at = pages_at;
    for (uint32_t i = root - 1; i < parts.header.blobs; at += parts.table[i++].bytes)
      pages.emplace_back(&parts.blobs[at], &parts.blobs[at] + parts.table[i].bytes);
    const auto numberOf = [&](uint32_t page) {
      return root + static_cast<uint32_t>(std::find(kOrder.begin(), kOrder.end(), page) - kOrder.begin());
    };
    HierarchyPage root_page = decodePage(pages[0], kRootKey, true);
    for (Node& node : root_page.nodes)
      if (node.child_page) node.child_page.number = numberOf(node.child_page.number - root);
    pages[0] = encodePage(root_page);
    parts.blobs.resize(pages_at);
    for (size_t i = 0; i < kOrder.size(); ++i) {
      const std::vector<std::byte>& page = pages[kOrder[i]];
      parts.blobs.insert(parts.blobs.end(), page.begin(), page.end());
      parts.table[root - 1 + i] = {static_cast<uint32_t>(page.size()), checksum(page), digestOf(page)};
    }
    parts.header.summary.root_page.number = numberOf(0);
    const uint64_t behind = parts.header.summary.bytes - parts.header.table_offset;
    parts.header.table_offset = kHeaderBytes + parts.blobs.size();
    parts.header.summary.bytes = parts.header.table_offset + behind;
  });
  EXPECT_EQ(message, "");
}

TEST_F(HostileIndex, stepsMustHaveThreeBitsAndBeInRange) {
  for (const double step :
       {0.0, -1.0, 9.0, 0.3, std::nan(""), std::numeric_limits<double>::infinity(), 0x1p-101, 0x1p61})
    EXPECT_SAYS(open([&](Parts& p) { p.header.summary.lattice.step = step; }), "step");
}

TEST_F(HostileIndex, originsMustBeMultiplesOfTheStep) {
  for (const double origin : {0.1, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_SAYS(open([&](Parts& p) { p.header.summary.lattice.origin.y = origin; }), "origin");
}

TEST_F(HostileIndex, boxesOutsideTheLatticeAreRefused) {
  EXPECT_SAYS(open([](Parts& p) { p.header.summary.box.max.z = kMaxLattice + 1; }), "outside the lattice");
}

TEST_F(HostileIndex, unknownAttributesAreRefused) {
  EXPECT_SAYS(open([](Parts& p) { p.header.summary.attributes.bits = 0x40; }), "attributes");
}

TEST_F(HostileIndex, moreNodesThanTheLimitAreRefused) {
  EXPECT_SAYS(open([](Parts& p) { p.header.summary.nodes = kMaxNodes + 1; }), "the limit is");
  EXPECT_SAYS(open([](Parts& p) { p.header.summary.nodes = 0; }), "the limit is");
}

TEST_F(HostileIndex, countsThatAreNotThoseOfTheNodesAreRefused) {
  EXPECT_SAYS(open([](Parts& p) { ++p.header.summary.nodes; }), "counts");
  EXPECT_SAYS(open([](Parts& p) { --p.header.summary.nodes; }), "more nodes");
  EXPECT_SAYS(open([](Parts& p) { ++p.header.summary.triangles; }), "counts");
  EXPECT_SAYS(open([](Parts& p) { ++p.header.summary.stored_triangles; }), "counts");
  EXPECT_SAYS(open([](Parts& p) { ++p.header.summary.payloads; }), "counts");
  EXPECT_SAYS(open([](Parts& p) { ++p.header.summary.depth; }), "counts");
  EXPECT_SAYS(open([](Parts& p) { p.header.summary.box.max.x -= 1; }), "box");
  EXPECT_SAYS(open([](Parts& p) { p.header.summary.max_error_model *= 2; }), "error");
}

TEST_F(HostileIndex, blobTablesThatDoNotEndWhereTheFileDoesAreRefused) {
  EXPECT_SAYS(open([](Parts& p) { --p.header.table_offset; }), "do not fill the rest");
  EXPECT_SAYS(open([](Parts& p) { ++p.header.blobs; }), "do not fill the rest");
  EXPECT_SAYS(open([](Parts& p) { p.header.blobs = 0xffffffff; }), "do not fill the rest");
  EXPECT_SAYS(open([](Parts& p) { p.header.table_offset = ~uint64_t{0}; }), "do not fill the rest");
}

TEST_F(HostileIndex, blobsMustFillTheSpaceBeforeTheTable) {
  EXPECT_SAYS(open([](Parts& p) { ++p.table[0].bytes; }), "do not fill");
  EXPECT_SAYS(open([](Parts& p) { p.table[0].bytes = 0; }), "empty blob");
  EXPECT_SAYS(open([](Parts& p) { p.table[0].bytes = kMaxBlobBytes + 1; }), "the limit is");
}

TEST_F(HostileIndex, blobsShiftedAgainstTheirSizesAreRefused) {
  EXPECT_SAYS(open([](Parts& p) {
                // Moves a byte from the preceding blob to the root's page.
                const uint32_t root = p.header.summary.root_page.number;
                --p.table[root - 2].bytes;
                ++p.table[root - 1].bytes;
              }),
              "checksum");
}

TEST_F(HostileIndex, blobsThatNothingUsesAreRefused) {
  EXPECT_SAYS(
      open([](Parts& p) {
        p.blobs.push_back(std::byte{1});
        p.table.push_back({1, checksum(std::span(p.blobs).last(1)), digestOf(std::span(p.blobs).last(1))});
        ++p.header.blobs;
        p.header.table_offset += 1;
        p.header.summary.bytes += 1 + kTableEntryBytes;
      }),
      "not used");
}

TEST_F(HostileIndex, missingRootPagesAreRefused) {
  EXPECT_SAYS(open([](Parts& p) { p.header.summary.root_page.number = 0; }), "root page");
  EXPECT_SAYS(open([](Parts& p) { p.header.summary.root_page.number = p.header.blobs + 1; }), "root page");
  EXPECT_NE(open([](Parts& p) { p.header.summary.root_page.number = 1; }), "");
}

TEST_F(HostileIndex, buildIdsThatAreNotTheHashOfTheIndexAreRefused) {
  EXPECT_SAYS(open([](Parts& p) { p.header.summary.build_id.bytes[3] ^= std::byte{1}; }, false), "build id");
}

TEST_F(HostileIndex, payloadsThatAreNotInTheBlobTableAreRefused) {
  const auto rootLod = [](HierarchyPage& page) -> Lod& { return page.nodes[0].lods[0]; };
  EXPECT_SAYS(openWithRootPage([&](HierarchyPage& page) { rootLod(page).payload.number = 100000; }),
              "missing blob");
  EXPECT_SAYS(openWithRootPage([&](HierarchyPage& page) { ++rootLod(page).payload.bytes; }), "blob table");
  EXPECT_SAYS(
      openWithRootPage([&](HierarchyPage& page) { rootLod(page).payload.digest.bytes[0] ^= std::byte{1}; }),
      "blob table");
}

TEST_F(HostileIndex, pagesThatTwoNodesNameAreRefused) {
  const auto twice = [](HierarchyPage& page) {
    BlobRef last;
    for (const Node& node : page.nodes)
      if (node.child_page) last = node.child_page;
    for (Node& node : page.nodes)
      if (node.child_page) node.child_page = last;
  };
  EXPECT_SAYS(openWithRootPage(twice), "two nodes refer to this page");
}

TEST_F(HostileIndex, pagesUsedAsPayloadsAreRefused) {
  EXPECT_SAYS(openWithRootPage([](HierarchyPage& page) {
                for (const Node& node : page.nodes)
                  if (node.child_page) page.nodes[0].lods[0].payload = node.child_page;
              }),
              "another use");
}

TEST_F(HostileIndex, invalidTextureSetsAreRefused) {
  EXPECT_SAYS(open([](Parts& parts) { parts.header.summary.textures.number = parts.header.blobs + 1; }),
              "texture set");
  EXPECT_SAYS(open([](Parts& parts) {
                parts.header.summary.textures.number = parts.header.summary.root_page.number;
              }),
              "texture set");
}

TEST_F(HostileIndex, pagesAndTextureSetsAboveTheirLimitsAreRefused) {
  const std::string page = open([](Parts& parts) {
    replaceBlob(parts, parts.header.summary.root_page.number, std::vector<std::byte>(kMaxPageBytes + 1));
  });
  EXPECT_SAYS(page, "a page larger than the limit");
  const std::string textures = open([](Parts& parts) {
    replaceBlob(parts, 1, std::vector<std::byte>(kMaxTextureSetBytes + 1));
    parts.header.summary.textures.number = 1;
  });
  EXPECT_SAYS(textures, "a texture set larger than the limit");
}

TEST_F(HostileIndex, pagesAndTextureSetsOfExactlyTheirLimitsAreRead) {
  const std::string page = open([](Parts& parts) {
    replaceBlob(parts, parts.header.summary.root_page.number, std::vector<std::byte>(kMaxPageBytes));
  });
  EXPECT_SAYS(page, "damaged hierarchy page");
  const std::string textures = open([](Parts& parts) {
    replaceBlob(parts, 1, std::vector<std::byte>(kMaxTextureSetBytes));
    parts.header.summary.textures.number = 1;
  });
  EXPECT_SAYS(textures, "damaged texture set");
}

TEST_F(HostileIndex, hierarchiesDeeperThanTheLimitAreRefused) {
  EXPECT_SAYS(open([](Parts& p) { p.header.summary.depth = kMaxDepth + 1; }), "too deep");
}

TEST_F(HostileIndex, pagesOfOtherNodesAreRefused) {
  const auto swapped = [](HierarchyPage& page) {
    std::vector<Node*> with_page;
    for (Node& node : page.nodes)
      if (node.child_page) with_page.push_back(&node);
    ASSERT_GE(with_page.size(), 2u);
    std::swap(with_page.front()->child_page, with_page.back()->child_page);
  };
  EXPECT_SAYS(openWithRootPage(swapped), "does not belong in it");
}

// A cache that trusted such a digest would mix up the data of two models.
TEST_F(HostileIndex, namesThatAreNotTheHashOfTheirBytesAreFoundByVerify) {
  EXPECT_EQ(openWithRootPage([](HierarchyPage&) {}), "");
  const auto path = folder_ / "hostile.lode";
  const std::string opened = open([](Parts& parts) {
    const uint32_t number = parts.header.summary.root_page.number;
    parts.table[number - 1].digest.bytes[0] ^= std::byte{1};
  });
  EXPECT_EQ(opened, "");
  EXPECT_SAYS(test::messageOf([&] { verifyStore(path); }), "its digest does not match its bytes");
}

TEST_F(HostileIndex, missingChildrenAreRefused) {
  EXPECT_NE(openWithRootPage([](HierarchyPage& page) { page.nodes.pop_back(); }), "");
  EXPECT_NE(openWithRootPage([](HierarchyPage& page) {
              for (Node& node : page.nodes)
                if (node.child_page) node.child_page = {};
            }),
            "");
}

TEST_F(HostileIndex, errorsThatFallTowardsAParentInAnotherPageAreRefused) {
  EXPECT_SAYS(openWithRootPage([](HierarchyPage& page) {
                for (Node& node : page.nodes)
                  if (node.child_page)
                    for (Lod& lod : node.lods) lod.error_model = 0;
              }),
              "I3");
}

}  // namespace
}  // namespace lode::store
