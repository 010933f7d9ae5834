#include "client/app/cli/store_cache.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

namespace fs = std::filesystem;
using std::chrono::hours;

constexpr size_t kStoreBytes = 1000;

/// Stores of three sources: a was last used two hours ago, b one hour ago, c now.
class StoreCache : public testing::Test {
 protected:
  StoreCache() {
    int age_h = 2;
    for (const char* name : {"a", "b", "c"}) {
      fs::create_directories(storeOf(name).parent_path());
      std::ofstream(storeOf(name)) << std::string(kStoreBytes, 'x');
      std::ofstream(storeOf(name).parent_path() / kBuildRecord) << "";
      for (const auto& entry : fs::directory_iterator(storeOf(name).parent_path()))
        fs::last_write_time(entry.path(), fs::file_time_type::clock::now() - hours(age_h));
      --age_h;
    }
  }
  fs::path storeOf(const std::string& name) const { return folder_ / name / "version" / (name + ".lode"); }
  /// Returns the names of the sources that still have stores.
  std::string kept() const {
    std::string names;
    for (const char* name : {"a", "b", "c"})
      if (fs::exists(storeOf(name))) names += name;
    return names;
  }

  const lode::test::WorkFolder folder_;
};

TEST_F(StoreCache, isLimitedToATenthOfTheDiskOr20GBAndToHalfOfIt) {
  constexpr uint64_t kGB = 1'000'000'000;
  EXPECT_EQ(storeCacheBytes(1000 * kGB), 100 * kGB);
  EXPECT_EQ(storeCacheBytes(100 * kGB), 20 * kGB);
  EXPECT_EQ(storeCacheBytes(30 * kGB), 15 * kGB);
}

TEST_F(StoreCache, isUnchangedWithinTheLimit) {
  trimStores(folder_.path(), 3 * kStoreBytes);
  EXPECT_EQ(kept(), "abc");
}

TEST_F(StoreCache, evictsTheLeastRecentlyUsedStoreAboveTheLimit) {
  trimStores(folder_.path(), 2 * kStoreBytes);
  EXPECT_EQ(kept(), "bc");
  EXPECT_FALSE(fs::exists(folder_ / "a"));
}

TEST_F(StoreCache, keepsAStoreThatWasJustUsed) {
  useStore(storeOf("a"));
  trimStores(folder_.path(), 2 * kStoreBytes);
  EXPECT_EQ(kept(), "ac");
}

TEST_F(StoreCache, removesNothingThroughALink) {
  const lode::test::WorkFolder elsewhere;
  std::ofstream(elsewhere / "thesis") << std::string(10 * kStoreBytes, 'x');
  fs::create_directory_symlink(elsewhere.path(), folder_ / "d");
  trimStores(folder_.path(), 0);
  EXPECT_EQ(kept(), "");
  EXPECT_EQ(elsewhere.contents(), std::vector<std::string>{"thesis"});
  const lode::test::WorkFolder links;
  fs::create_directory_symlink(elsewhere.path(), links / "stores");
  fs::create_directory(elsewhere / "source");
  trimStores(links / "stores", 0);
  EXPECT_TRUE(fs::exists(elsewhere / "source"));
}

TEST_F(StoreCache, keepsStoresInUse) {
  const FileLock in_use = useStore(storeOf("b")), in_use_twice = useStore(storeOf("b"));
  trimStores(folder_.path(), 0);
  EXPECT_EQ(kept(), "b");
}

TEST_F(StoreCache, keepsStoresBeingBuilt) {
  const auto builds = FileLock::tryTake(folder_ / "a" / kStoreBuildLock, FileLock::Kind::kExclusive, true);
  trimStores(folder_.path(), 0);
  EXPECT_EQ(kept(), "a");
}

TEST_F(StoreCache, removesTheRemainsOfAKilledBuild) {
  fs::remove(storeOf("a"));
  const fs::path left = storeOf("a").parent_path() / ".a.lode.building";
  std::ofstream(left) << std::string(kStoreBytes, 'x');
  fs::last_write_time(left, fs::file_time_type::clock::now() - hours(2));
  trimStores(folder_.path(), 2 * kStoreBytes);
  EXPECT_FALSE(fs::exists(left));
}

TEST_F(StoreCache, isLimitedByTheCapacityOfItsDisk) {
  const uint64_t tenth = fs::space(folder_.path()).capacity / 10;
  EXPECT_EQ(storeCacheBytes(folder_.path()), std::max<uint64_t>(tenth, 20'000'000'000));
}

}  // namespace
}  // namespace lode::app
