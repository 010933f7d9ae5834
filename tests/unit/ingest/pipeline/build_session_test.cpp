#include "server/ingest/pipeline/build_session.h"

#include <algorithm>
#include <fstream>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

/// A stage that writes a file and saves a number.
class SmallStage final : public Stage {
 public:
  SmallStage(BuildSession& session, Traits traits) : Stage(std::move(traits)), session_(session) {}

  bool isNeeded() const override { return is_needed; }
  Work run() override {
    ++runs;
    made = 7;
    for (const std::string_view name : traits().files) std::ofstream(session_.files().path() / name) << made;
    return {};
  }
  bool isOnDisk() const override { return is_on_disk; }
  void save(RecordWriter& record) const override { record.put(made); }
  void load(RecordReader& record, bool is_used_up) override {
    made = record.get<int>();
    was_used_up = is_used_up;
  }

  bool is_needed = true, is_on_disk = true;
  int runs = 0, made = 0;
  bool was_used_up = false;

 private:
  BuildSession& session_;
};

class Session : public testing::Test {
 protected:
  void SetUp() override {
    options_.input = folder_ / "a.ply";
    std::ofstream(options_.input) << "ply\n";
    options_.output = folder_ / "a.lode";
    options_.temporary_folder = folder_.path();
    options_.memory_bytes = 1 << 20;
    options_.threads = 1;
    options_.resume = true;
  }

  /// A build with three stages: scan, dereference, partition.
  struct Build {
    explicit Build(const BuildOptions& options) : session(options, progress) {}

    BuildProgress progress;
    BuildSession session;
    SmallStage scan{session, {"scan", BuildEntry::kScanned, BuildEntry::kDereferenced, {"vertices"}}};
    SmallStage dereference{session,
                           {"dereference", BuildEntry::kDereferenced, BuildEntry::kPartitioned, {"runs"}}};
    SmallStage partition{session,
                         {"partition", BuildEntry::kPartitioned, BuildEntry::kSimplified, {"leaves"}}};
  };

  bool hasFile(std::string_view name) const {
    const auto names = folder_.contents();
    return std::ranges::any_of(names, [&](const std::string& found) { return found.ends_with(name); });
  }

  test::WorkFolder folder_;
  BuildOptions options_;
};

TEST_F(Session, runsOnlyTheStagesThatAnotherLeftUnfinished) {
  {
    Build first(options_);
    first.session.run(first.scan);
    EXPECT_TRUE(first.session.keep());
  }
  Build second(options_);
  second.session.run(second.scan);
  second.session.run(second.dereference);
  EXPECT_EQ(second.scan.runs, 0);
  EXPECT_EQ(second.scan.made, 7);
  EXPECT_FALSE(second.scan.was_used_up);
  EXPECT_EQ(second.dereference.runs, 1);
  EXPECT_EQ(second.session.takeReport().resumed_from, "dereference");
}

TEST_F(Session, keepsNothingOfABuildThatHasFinishedNoStage) {
  const auto before = folder_.contents();
  {
    Build build(options_);
    EXPECT_FALSE(build.session.keep());
  }
  EXPECT_EQ(folder_.contents(), before);
}

TEST_F(Session, removesAStagesFilesOnceTheNextStageIsRecorded) {
  Build build(options_);
  build.session.run(build.scan);
  EXPECT_TRUE(hasFile("vertices"));
  build.session.run(build.dereference);
  EXPECT_FALSE(hasFile("vertices"));
  EXPECT_TRUE(hasFile("runs"));
}

TEST_F(Session, repeatsAnInMemoryStageFromItsInputFiles) {
  {
    Build first(options_);
    first.dereference.is_on_disk = false;
    first.session.run(first.scan);
    first.session.run(first.dereference);
    EXPECT_TRUE(hasFile("vertices"));
    first.session.keep();
  }
  Build second(options_);
  second.session.run(second.scan);
  EXPECT_FALSE(second.scan.was_used_up);
  second.session.run(second.dereference);
  EXPECT_EQ(second.dereference.runs, 1);
}

TEST_F(Session, skipsAnInMemoryStageOnceTheNextStageIsRecorded) {
  {
    Build first(options_);
    first.dereference.is_on_disk = false;
    for (Stage* stage : {&first.scan, &first.dereference, &first.partition}) first.session.run(*stage);
    first.session.keep();
  }
  Build second(options_);
  for (Stage* stage : {&second.scan, &second.dereference, &second.partition}) second.session.run(*stage);
  EXPECT_TRUE(second.scan.was_used_up);
  EXPECT_EQ(second.dereference.runs + second.partition.runs, 0);
  EXPECT_FALSE(second.partition.was_used_up);
}

TEST_F(Session, remembersFactsAndWarningsAcrossBuilds) {
  {
    Build first(options_);
    first.session.facts().dropped_triangles = 3;
    first.session.warn("a warning");
    first.session.run(first.scan);
    first.session.keep();
  }
  Build second(options_);
  second.session.run(second.scan);
  EXPECT_EQ(second.session.facts().dropped_triangles, 3u);
  EXPECT_EQ(second.session.takeReport().warnings, std::vector<std::string>{"a warning"});
}

TEST_F(Session, treatsWarningsAsErrorsIfStrict) {
  options_.strict = true;
  Build build(options_);
  EXPECT_THROW(build.session.warn("a warning"), Error);
}

TEST_F(Session, skipsAStageThatTheInputDoesNotNeed) {
  Build build(options_);
  build.scan.is_needed = false;
  build.session.run(build.scan);
  EXPECT_EQ(build.scan.runs, 0);
  EXPECT_TRUE(build.session.takeReport().stages.empty());
}

}  // namespace
}  // namespace lode::ingest
