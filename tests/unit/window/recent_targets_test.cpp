#include "client/app/window/recent_targets.h"

#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

namespace fs = std::filesystem;

class RecentTargetsTest : public testing::Test {
 protected:
  std::string fileOf(const std::string& name) const { return (work_ / name).string(); }

  const test::WorkFolder work_;
  const fs::path folder_ = work_ / "cache";
  const RecentTargets recent_{folder_};
};

TEST_F(RecentTargetsTest, areEachKeptOnceNewestFirst) {
  EXPECT_TRUE(recent_.read().empty());
  for (const char* const name : {"a.ply", "b.lode", "a.ply"}) recent_.add(fileOf(name));
  recent_.add("lode://host/rock");
  EXPECT_EQ(RecentTargets(folder_).read(),
            (std::vector<std::string>{"lode://host/rock", fileOf("a.ply"), fileOf("b.lode")}));
}

TEST_F(RecentTargetsTest, areKnownByTheirAbsolutePaths) {
  recent_.add("a.ply");
  EXPECT_EQ(recent_.read().front(), (fs::current_path() / "a.ply").string());
}

TEST_F(RecentTargetsTest, areBounded) {
  for (size_t i = 0; i < kMostRecentTargets + 5; ++i) recent_.add(fileOf(std::to_string(i)));
  ASSERT_EQ(recent_.read().size(), kMostRecentTargets);
  EXPECT_EQ(recent_.read().back(), fileOf("5"));
  recent_.add(fileOf(std::string(5000, 'a')));
  EXPECT_EQ(recent_.read().front(), fileOf(std::to_string(kMostRecentTargets + 4)));
}

TEST_F(RecentTargetsTest, areReadableByTheUserOnly) {
  recent_.add(fileOf("a.ply"));
  EXPECT_EQ(fs::status(folder_ / "recent.json").permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(fs::status(folder_).permissions(), fs::perms::owner_all);
}

TEST_F(RecentTargetsTest, areEmptyIfTheirFileIsDamaged) {
  recent_.add(fileOf("a.ply"));
  for (const std::string& text :
       {std::string("{"), std::string("7"), std::string("[1, {}]"), std::string(1 << 20, '[')}) {
    std::ofstream(folder_ / "recent.json") << text;
    EXPECT_TRUE(recent_.read().empty());
  }
}

TEST_F(RecentTargetsTest, tolerateAnUnwritableFolder) {
  const RecentTargets nowhere("/proc/lodestream");
  nowhere.add(fileOf("a.ply"));
  EXPECT_TRUE(nowhere.read().empty());
}

TEST_F(RecentTargetsTest, areMissingIfTheirFileIsGone) {
  EXPECT_TRUE(isMissing(fileOf("a.ply")));
  std::ofstream(fileOf("a.ply")) << "ply";
  EXPECT_FALSE(isMissing(fileOf("a.ply")));
  EXPECT_FALSE(isMissing("lode://host/rock"));
}

}  // namespace
}  // namespace lode::app
