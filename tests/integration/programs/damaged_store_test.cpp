// Tests of damaged stores, in which a byte is changed or the end is missing.

#include <algorithm>
#include <iterator>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "programs.h"
#include "server/store/reader.h"

namespace lode::test {
namespace {

enum class Part { kHeader, kPayload, kOriginal, kPage, kTable, kFooter };

/// Position of a changed byte, and the part of the store that contains it.
struct Damage {
  uint64_t offset = 0;
  Part part = Part::kHeader;
};

constexpr uint64_t kHeaderBytes = 188, kFooterBytes = 24;
constexpr int kPlacesInAPart = 10;

/// Chooses random positions in every part of a store, from a seed.
class DamagePlan {
 public:
  explicit DamagePlan(const std::filesystem::path& store) : reader_(store) {
    std::set<uint32_t> pages{reader_.summary().root_page.number}, originals;
    for (const Node& node : reader_.nodes()) {
      if (node.child_page.number != 0) pages.insert(node.child_page.number);
      if (node.isLeaf() && node.lods[0].payload.number != 0) originals.insert(node.lods[0].payload.number);
    }
    std::vector<uint32_t> payloads;
    uint64_t table = 0;
    for (uint32_t number = 1; number <= reader_.blobCount(); ++number) {
      table = reader_.blob(number).offset + reader_.blob(number).bytes;
      if (!pages.contains(number) && !originals.contains(number)) payloads.push_back(number);
    }
    const uint64_t footer = std::filesystem::file_size(store) - kFooterBytes;
    for (int i = 0; i < kPlacesInAPart; ++i) {
      addWithin(0, kHeaderBytes, Part::kHeader);
      addInABlob(payloads, Part::kPayload);
      addInABlob({originals.begin(), originals.end()}, Part::kOriginal);
      addInABlob({pages.begin(), pages.end()}, Part::kPage);
      addWithin(table, footer - table, Part::kTable);
      addWithin(footer, kFooterBytes, Part::kFooter);
    }
  }

  const std::vector<Damage>& places() const noexcept { return places_; }
  /// Returns the store's bytes with one byte changed.
  std::string apply(std::string bytes, const Damage& damage) {
    bytes[damage.offset] = static_cast<char>(bytes[damage.offset] ^ (1 + random_() % 255));
    return bytes;
  }

 private:
  void addWithin(uint64_t offset, uint64_t bytes, Part part) {
    places_.push_back({offset + random_() % bytes, part});
  }
  void addInABlob(const std::vector<uint32_t>& numbers, Part part) {
    const store::BlobEntry& blob = reader_.blob(numbers[random_() % numbers.size()]);
    addWithin(blob.offset, blob.bytes, part);
  }

  store::Reader reader_;
  std::mt19937 random_{20260};
  std::vector<Damage> places_;
};

class DamagedStore : public testing::Test {
 protected:
  /// Streams the original triangles of all leaves into cut.ply. @return the outcome. The stream never
  /// converges, because no lattice is as fine as the requested precision.
  Outcome fetchAll(const std::filesystem::path& store) const {
    std::filesystem::remove(cut_);
    return lodestream({"fetch", store, "--pixels", "0.01", "--timeout", "60", "-o", cut_});
  }

  /// For each payload of a coarser level, changes a byte in a copy of the store, damaged.lode, and calls the
  /// function.
  template <typename Act>
  void damagePayloads(const Act& act) const {
    DamagePlan plan(sound_);
    for (const Damage& damage : plan.places()) {
      if (damage.part != Part::kPayload) continue;
      SCOPED_TRACE("byte " + std::to_string(damage.offset));
      writeBytes(damaged_, plan.apply(readBytes(sound_), damage));
      act();
    }
  }

  const WorkFolder folder_;
  const std::filesystem::path sound_ = makeSmallStore(folder_), damaged_ = folder_ / "damaged.lode",
                              cut_ = folder_ / "cut.ply";
};

TEST_F(DamagedStore, isFoundByVerifyWhereverAByteHasChanged) {
  DamagePlan plan(sound_);
  EXPECT_EQ(lodestreamd({"verify", sound_}).status, 0);
  for (const Damage& damage : plan.places()) {
    SCOPED_TRACE("byte " + std::to_string(damage.offset));
    writeBytes(damaged_, plan.apply(readBytes(sound_), damage));
    expectFailure(lodestreamd({"verify", damaged_}), {"damaged.lode"});
  }
}

TEST_F(DamagedStore, isNotServedIfItsIndexHasChanged) {
  DamagePlan plan(sound_);
  for (const Damage& damage : plan.places()) {
    if (damage.part == Part::kPayload || damage.part == Part::kOriginal) continue;
    SCOPED_TRACE("byte " + std::to_string(damage.offset));
    writeBytes(damaged_, plan.apply(readBytes(sound_), damage));
    expectFailure(lodestreamd({"serve", damaged_, "--listen", "127.0.0.1:0"}), {"damaged.lode"});
    expectFailure(fetchAll(damaged_), {"damaged.lode"});
  }
}

TEST_F(DamagedStore, givesNoWrongCut) {
  DamagePlan plan(sound_);
  fetchAll(sound_);
  ASSERT_TRUE(std::filesystem::exists(cut_));
  const std::string right_cut = readBytes(cut_);
  for (const Damage& damage : plan.places()) {
    if (damage.part != Part::kPayload && damage.part != Part::kOriginal) continue;
    SCOPED_TRACE("byte " + std::to_string(damage.offset));
    writeBytes(damaged_, plan.apply(readBytes(sound_), damage));
    const Outcome outcome = fetchAll(damaged_);
    if (std::filesystem::exists(cut_) && damage.part == Part::kPayload) {  // the damaged LOD was not needed
      EXPECT_TRUE(readBytes(cut_) == right_cut);
    } else {
      expectFailure(outcome, {"damaged.lode"});
      EXPECT_FALSE(std::filesystem::exists(cut_));
    }
  }
}

TEST_F(DamagedStore, isShownInFinerLodsWhereACoarserLodIsDamaged) {
  bool has_met_damage = false;
  damagePayloads([&] {
    const Outcome outcome = lodestream({"fetch", damaged_, "--pixels", "8", "--timeout", "60", "-o", cut_});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    has_met_damage |= outcome.err.find("shown without an unavailable part") != std::string::npos;
  });
  EXPECT_TRUE(has_met_damage);
}

TEST_F(DamagedStore, canBeLoadTestedWithoutItsDamagedBlobs) {
  bool has_met_damage = false;
  damagePayloads([&] {
    if (has_met_damage) return;
    const Outcome outcome =
        lodestream({"loadtest", damaged_, "--clients", "1", "--seconds", "1", "--pixels", "8", "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_GT(nlohmann::json::parse(outcome.out)["blobs"], 0);
    has_met_damage = outcome.err.find("do not request an unavailable part") != std::string::npos;
  });
  EXPECT_TRUE(has_met_damage);
}

TEST_F(DamagedStore, isRefusedIfTruncated) {
  const std::string bytes = readBytes(sound_);
  for (const size_t length : {size_t{1}, size_t{187}, size_t{188}, bytes.size() / 2, bytes.size() - 25,
                              bytes.size() - 24, bytes.size() - 1}) {
    SCOPED_TRACE(std::to_string(length) + " bytes");
    writeBytes(damaged_, bytes.substr(0, length));
    for (const char* command : {"verify", "info"})
      expectFailure(lodestreamd({command, damaged_}), {"damaged.lode"});
    expectFailure(lodestreamd({"serve", damaged_, "--listen", "127.0.0.1:0"}), {"damaged.lode"});
    expectFailure(fetchAll(damaged_), {"damaged.lode"});
  }
  EXPECT_FALSE(std::filesystem::exists(cut_));
}

}  // namespace
}  // namespace lode::test
