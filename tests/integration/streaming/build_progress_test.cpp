// A PLY as a target: the client builds it by the server's program, and says how far that is.

#include <cstdlib>

#include <gtest/gtest.h>

#include "client/app/cli/child_server.h"
#include "tests/support/work_folder.h"

namespace lode::test {
namespace {

TEST(BuildOfATarget, tellsItsStagesAndHowFarTheyAreAndNothingWhereItWasDoneBefore) {
  const std::filesystem::path ply = std::filesystem::path(LODE_BIN_DIR) / "test-models" / "painted.ply";
  const WorkFolder cache;
  setenv("XDG_CACHE_HOME", cache.path().c_str(), 1);
  std::vector<std::string> stages;
  const auto watch = [&](std::string_view stage, double fraction) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
  };
  app::resolveTarget(app::PlyFile{ply}, {}, true, {}, watch);
  EXPECT_TRUE(std::ranges::count(stages, "scan") == 1 && std::ranges::count(stages, "simplify") == 1);
  stages.clear();
  app::resolveTarget(app::PlyFile{ply}, {}, true, {}, watch);
  EXPECT_TRUE(stages.empty());
}

}  // namespace
}  // namespace lode::test
