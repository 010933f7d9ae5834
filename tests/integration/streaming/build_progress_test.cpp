// Tests of a PLY file as target. The client builds a store by lodestreamd and reports the progress.

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stop_token>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/app/cli/child_server.h"
#include "common/error.h"
#include "tests/integration/programs/programs.h"
#include "tests/support/work_folder.h"

namespace lode::test {
namespace {

TEST(BuildOfATarget, reportsItsStagesAndProgressUnlessTheStoreExists) {
  const std::filesystem::path ply = std::filesystem::path(LODE_BIN_DIR) / "test-models" / "painted.ply";
  const WorkFolder cache;
  setenv("XDG_CACHE_HOME", cache.path().c_str(), 1);
  std::vector<std::string> stages;
  double last = 0, triangles = 0;
  app::BuildWatch watch;
  watch.on_step = [&](const app::BuildStep& step) {
    EXPECT_GE(step.fraction, last);
    EXPECT_LE(step.fraction, 1);
    last = step.fraction;
    if (step.doing == "simplifying" && step.total > 0) triangles = step.total;
    if (stages.empty() || stages.back() != step.doing) stages.push_back(step.doing);
  };
  app::builtStore({ply}, true, {}, watch);
  EXPECT_TRUE(std::ranges::count(stages, "reading the file") == 1 &&
              std::ranges::count(stages, "simplifying") == 1);
  EXPECT_EQ(last, 1);
  EXPECT_GT(triangles, 50'000);
  stages.clear();
  app::builtStore({ply}, true, {}, watch);
  EXPECT_TRUE(stages.empty());
}

TEST(BuildOfATarget, continuesAfterItWasCancelled) {
  const WorkFolder folder, cache;
  setenv("XDG_CACHE_HOME", cache.path().c_str(), 1);
  const std::filesystem::path ply = folder / "a.ply";
  const Outcome sample =
      Program("lodestreamd", {"sample", "asteroid", "--triangles", "400000", "-o", ply.string()}).wait();
  ASSERT_EQ(sample.status, 0) << sample.err;
  std::stop_source stop;
  std::vector<std::string> stages;
  app::BuildWatch watch;
  int previews = 0;
  watch.on_preview = [&](const std::filesystem::path& preview) {
    EXPECT_TRUE(std::filesystem::exists(preview));
    ++previews;
  };
  watch.on_step = [&](const app::BuildStep& step) {
    stages.push_back(step.doing);
    if (step.doing == "simplifying") stop.request_stop();
  };
  EXPECT_THROW(app::builtStore({ply}, false, stop.get_token(), watch), Error);
  ASSERT_EQ(stages.front(), "reading the file");
  stages.clear();
  watch.on_step = [&](const app::BuildStep& step) { stages.push_back(step.doing); };
  const app::BuiltStore store = app::builtStore({ply}, false, {}, watch);
  EXPECT_EQ(std::ranges::count(stages, "reading the file"), 0);
  EXPECT_EQ(previews, 2) << "a resumed build shows the preview of the earlier build";
  const Outcome verdict = Program("lodestreamd", {"verify", store.path.string()}).wait();
  EXPECT_EQ(verdict.status, 0) << verdict.err;
}

/// Two files, and cache space for the store of one of them.
class StoresOfTargets : public testing::Test {
 protected:
  StoresOfTargets() {
    setenv("XDG_CACHE_HOME", folder_.path().c_str(), 1);
    for (const auto& ply : {first_, second_})
      std::ofstream(ply) << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                            "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                            "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  }
  void buildTheSecond() const { app::builtStore({second_}, false, {}, {}, 1); }

  const WorkFolder folder_;
  const std::filesystem::path first_ = folder_ / "first.ply", second_ = folder_ / "second.ply";
};

TEST_F(StoresOfTargets, areRemovedOnTheNextBuildIfUnused) {
  const std::filesystem::path first = app::builtStore({first_}, false, {}, {}).path;
  buildTheSecond();
  EXPECT_FALSE(std::filesystem::exists(first));
}

TEST_F(StoresOfTargets, areKeptBesideAPreviewWithoutABuild) {
  const std::filesystem::path store = app::builtStore({first_}, false, {}, {}).path;
  const std::filesystem::path preview = app::builtStore({first_, {}, true}, false, {}, {}).path;
  EXPECT_NE(preview, store);
  EXPECT_TRUE(std::filesystem::exists(preview));
  EXPECT_EQ(app::builtStore({first_, {}, true}, false, {}, {}).path, preview);
  EXPECT_TRUE(std::filesystem::exists(store));
}

TEST_F(StoresOfTargets, areKeptWhileTheTargetIsOpen) {
  const app::ResolvedTarget open = app::resolveTarget(app::PlyFile{first_}, {}, false);
  const std::filesystem::path first = app::builtStore({first_}, false, {}, {}).path;
  buildTheSecond();
  EXPECT_TRUE(std::filesystem::exists(first));
}

}  // namespace
}  // namespace lode::test
