// Tests of models that arrive through a pipe.

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "programs.h"

namespace lode::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class StandardInput : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "20000", "-o", ply_}).status, 0);
  }

  /// Runs a program under test at the end of a pipe. @param sender  shell command that writes into the pipe.
  Outcome pipe(const std::string& sender, const std::string& program,
               const std::vector<std::string>& arguments) const {
    std::vector<std::string> words{"-c", sender + " | \"$0\" \"$@\"",
                                   std::string(LODE_BIN_DIR "/bin/") + program};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return Program("sh", words, {"XDG_CACHE_HOME=" + (folder_ / "cache").string()}).wait();
  }

  std::string sendFile() const { return "cat '" + ply_.string() + "'"; }

  const WorkFolder folder_;
  const fs::path ply_ = folder_ / "a.ply", store_ = folder_ / "out/piped.lode";
};

TEST_F(StandardInput, givesTheSameStoreAsAFile) {
  fs::create_directory(folder_ / "out");
  const Outcome built = pipe(sendFile(), "lodestreamd", {"build", "-", "-o", store_});
  EXPECT_EQ(built.status, 0) << built.err;
  ASSERT_EQ(lodestreamd({"build", ply_, "-o", folder_ / "file.lode"}).status, 0);
  EXPECT_TRUE(readBytes(store_) == readBytes(folder_ / "file.lode"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "out"), {}), 1) << "a copy of the input is left";
}

TEST_F(StandardInput, isRefusedIfItEndsTooEarly) {
  fs::create_directory(folder_ / "out");
  expectFailure(pipe("head -c 100000 '" + ply_.string() + "'", "lodestreamd", {"build", "-", "-o", store_}),
                {"standard-input.ply", "truncated"});
  EXPECT_TRUE(fs::is_empty(folder_ / "out"));
}

TEST_F(StandardInput, isRefusedAtItsFirstBytesIfItIsNoPly) {
  expectFailure(pipe("yes", "lodestreamd", {"build", "/dev/stdin", "-o", folder_ / "a.lode"}),
                {"standard input", "not a PLY"});
}

TEST_F(StandardInput, cannotBeReadAgainToResumeABuild) {
  const Outcome resumed =
      pipe(sendFile(), "lodestreamd", {"build", "-", "-o", folder_ / "a.lode", "--resume"});
  EXPECT_EQ(resumed.status, 2) << resumed.err;
}

TEST_F(StandardInput, isShownByTheClientAndNotKept) {
  for (const bool is_preview : {false, true}) {
    std::vector<std::string> arguments{"fetch", "-", "--json", "--pixels", "0.01"};
    if (is_preview) arguments.emplace_back("--preview");
    const Outcome fetched = pipe(sendFile(), "lodestream", arguments);
    EXPECT_EQ(fetched.status, 0) << fetched.err;
    const Json json = Json::parse(fetched.out, nullptr, false);
    EXPECT_EQ(json["converged"], true);
    EXPECT_EQ(json["preview"], is_preview);
    EXPECT_TRUE(fs::is_empty(folder_ / "cache/lodestream/stores"));
  }
}

}  // namespace
}  // namespace lode::test
