// Tests of a client that is killed while it writes its cache, or whose disk is full. The next client must
// show the same picture.

#include <chrono>
#include <csignal>
#include <filesystem>
#include <optional>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "programs.h"

namespace lode::test {
namespace {

using Clock = std::chrono::steady_clock;
using Strings = std::vector<std::string>;

constexpr double kMostBytesOfAFile = 2000;  // typical size of a blob of these models

struct Kills {
  int all = 0, while_writing = 0;
};

int unfinishedFiles(const std::filesystem::path& cache) {
  int count = 0;
  if (!std::filesystem::exists(cache)) return 0;
  for (const auto& file : std::filesystem::recursive_directory_iterator(cache))
    count += file.path().filename().string().starts_with(".new-") ? 1 : 0;
  return count;
}

class KilledClient : public testing::Test {
 protected:
  KilledClient() {
    const std::string ply = folder_ / "a.ply", store = folder_ / "a.lode";
    EXPECT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "30000", "-o", ply}).status, 0);
    EXPECT_EQ(lodestreamd({"build", ply, "-o", store, "--triangles-per-node", "256", "--quiet"}).status, 0);
    server_.emplace(std::vector<std::filesystem::path>{store});
    const auto began = Clock::now();
    EXPECT_EQ(lodestream(fetch({"-o", folder_ / "expected.ply", "--cache", folder_ / "timed"})).status, 0);
    undisturbed_ = Clock::now() - began;
    expected_ = readBytes(folder_ / "expected.ply");
  }

  Strings fetch(const Strings& more) const {
    Strings all{"fetch", server_->url("a"), "--pixels", "0.3"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  void expectTheSameCut(const Strings& more) const {
    Strings all = more;
    all.insert(all.end(), {"-o", folder_ / "found.ply"});
    const Outcome outcome = lodestream(fetch(all));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(readBytes(folder_ / "found.ply") == expected_);
  }

  /// @param moment  time as a fraction of a client's run time. @return true if the client was still running.
  bool killsAt(double moment, const std::string& cache) const {
    Program client("lodestream", fetch({"--cache", cache}));
    std::this_thread::sleep_for(moment * undisturbed_);
    client.signal(SIGKILL);
    return client.wait().status == 128 + SIGKILL;
  }

  /// Runs a client with a limit of the file size. The system kills the client at the write that exceeds the
  /// limit. @return true if the client was killed.
  bool killsWhileWriting(int longest_bytes, const std::string& cache) const {
    Strings limited{"--core=0", "--fsize=" + std::to_string(longest_bytes), LODE_BIN_DIR "/bin/lodestream"};
    const Strings fetching = fetch({"--cache", cache});
    limited.insert(limited.end(), fetching.begin(), fetching.end());
    return Program("prlimit", limited).wait().status == 128 + SIGXFSZ;
  }

  /// Kills clients, alternately at a random moment and while they write a random file of their cache. After
  /// every third kill, a client shows the whole model, then shows it again without the server. @return number
  /// of killed clients, and how many of them left a partial file.
  Kills killMany(int kills, uint32_t seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0, 1);
    const std::string cache = folder_ / "cache";
    Kills killed;
    for (int rounds = 0; killed.all < kills && rounds < 4 * kills && !HasFailure(); ++rounds) {
      const int unfinished = unfinishedFiles(cache);
      const double drawn = part(random);
      const bool within_a_file = rounds % 2 == 0;
      const bool hit = within_a_file
                           ? killsWhileWriting(1 + static_cast<int>(drawn * kMostBytesOfAFile), cache)
                           : killsAt(drawn * drawn, cache);  // an early moment, because later everything is
                                                             // in the cache
      if (hit) ++killed.all;
      const bool left_a_part = unfinishedFiles(cache) > unfinished;
      if (left_a_part) ++killed.while_writing;
      EXPECT_TRUE(left_a_part || !hit || !within_a_file) << rounds;
      if (rounds % 3 != 2) continue;
      expectTheSameCut({"--cache", cache});
      expectTheSameCut({"--cache", cache, "--offline"});
      std::filesystem::remove_all(cache);
    }
    return killed;
  }

  WorkFolder folder_;
  std::optional<RunningServer> server_;
  std::chrono::duration<double> undisturbed_{};
  std::string expected_;
};

TEST_F(KilledClient, leavesACacheThatGivesTheNextClientTheSameCut) { EXPECT_EQ(killMany(10, 1).all, 10); }

TEST_F(KilledClient, fetchesTheSameCutIfTheDiskOfItsCacheIsFull) {
  if (Program("unshare", {"--mount", "true"}).wait().status != 0)
    GTEST_SKIP() << "no mount namespaces on this system";
  const std::string disk = folder_ / "disk", found = folder_ / "found.ply";
  std::filesystem::create_directory(disk);
  const std::string script = "mount -t tmpfs -o size=64k tmpfs " + disk +
                             " && '" LODE_BIN_DIR "/bin/lodestream' fetch " + server_->url("a") +
                             " --pixels 0.3 --cache " + disk + " -o " + found + " && test $(du -s " + disk +
                             " | cut -f1) -gt 32";
  const Outcome outcome = Program("unshare", {"--mount", "sh", "-c", script}).wait();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(readBytes(found) == expected_);
}

using SlowKilledClient = KilledClient;

TEST_F(SlowKilledClient, leavesAGoodCacheTwoHundredTimes) {
  const Kills killed = killMany(200, 2);
  EXPECT_EQ(killed.all, 200);
  RecordProperty("while_writing", killed.while_writing);
  EXPECT_GE(killed.while_writing, 80);
}

}  // namespace
}  // namespace lode::test
