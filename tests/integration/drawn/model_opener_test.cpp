// Tests of opening a PLY file: its preview, and then its store in the same stream.

#include "client/app/window/scene/model_opener.h"

#include <csignal>
#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/work_folder.h"

namespace lode::test {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 240s;

/// Ends the `lodestreamd build` that this process has started.
void endBuild() {
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream status(entry.path() / "status"), command(entry.path() / "cmdline");
    const std::string words((std::istreambuf_iterator<char>(command)), {});
    if (words.find(std::string("\0build\0", 7)) == std::string::npos) continue;
    for (std::string line; std::getline(status, line);)
      if (line == "PPid:\t" + std::to_string(getpid()))
        kill(std::stoi(entry.path().filename().string()), SIGKILL);
  }
}

class OpenedPly : public testing::Test {
 protected:
  explicit OpenedPly(const char* name = "painted.ply")
      : ply_(std::filesystem::path(LODE_BIN_DIR) / "test-models" / name) {
    setenv("XDG_CACHE_HOME", cache_.path().c_str(), 1);
    opener_.emplace(app::PlyFile{ply_}, stream::StreamOptions(), core::Framing(), kPatience, true);
  }

  /// Polls until the condition holds. @return false if it does not hold in time.
  template <class Condition>
  bool eventually(Condition condition) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < end && !condition(opener_->progress()))
      std::this_thread::sleep_for(5ms);
    return condition(opener_->progress());
  }
  static bool showsPreview(const app::ModelOpener::Progress& now) { return now.streamer && now.is_preview; }

  const std::filesystem::path ply_;
  const WorkFolder cache_;
  std::optional<app::ModelOpener> opener_;
};

TEST_F(OpenedPly, showsItsPreviewAndThenItsStoreInTheSameStream) {
  ASSERT_TRUE(eventually(showsPreview));
  const app::ModelOpener::Progress preview = opener_->progress();
  EXPECT_EQ(preview.model->nodes, 1u);
  EXPECT_TRUE(preview.streamer->status().cut);
  ASSERT_TRUE(eventually([](const auto& now) { return now.streamer && !now.is_preview; }));
  const app::ModelOpener::Progress store = opener_->progress();
  EXPECT_EQ(store.streamer, preview.streamer);
  EXPECT_GT(store.model->nodes, 1u);
  EXPECT_EQ(store.model->lattice, preview.model->lattice);
  EXPECT_EQ(store.phase, "");
  EXPECT_EQ(preview.model->nodes, 1u) << "its summary must live as long as the opener";
}

/// A file whose build takes much longer than its preview.
class OpenedLargePly : public OpenedPly {
 protected:
  OpenedLargePly() : OpenedPly("asteroid2m.ply") {}
};

TEST_F(OpenedLargePly, keepsItsPreviewWithAWarningIfTheBuildFails) {
  ASSERT_TRUE(eventually(showsPreview));
  endBuild();
  ASSERT_TRUE(eventually([](const auto& now) { return !now.warnings.empty(); }));
  const app::ModelOpener::Progress now = opener_->progress();
  EXPECT_TRUE(showsPreview(now));
  EXPECT_FALSE(now.error);
  EXPECT_EQ(now.warnings.front().find("only a preview is shown: "), 0u) << now.warnings.front();
  EXPECT_TRUE(now.streamer->status().cut);
}

}  // namespace
}  // namespace lode::test
