// Tests of lodestreamd build --resume. A build is killed at any moment, and the same command continues it.
// The store must equal the store of an undisturbed build.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <random>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/integration/programs/programs.h"

namespace lode::test {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;
using Strings = std::vector<std::string>;

constexpr int kKilled = 128 + SIGKILL;

class ResumedBuild : public testing::Test {
 protected:
  void makeModel(int triangles, int triangles_per_node) {
    ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", std::to_string(triangles), "--attributes",
                           "normal", "-o", input_})
                  .status,
              0);
    command_ = {"build",  input_,   "-o", output_, "--triangles-per-node", std::to_string(triangles_per_node),
                "--json", "--quiet"};
    const auto began = Clock::now();
    ASSERT_EQ(lodestreamd(command_).status, 0);
    undisturbed_ = Clock::now() - began;
    expected_ = readBytes(output_);
    std::filesystem::remove(output_);
    before_ = folder_.contents();
  }

  static void expectEndBySigterm(const Outcome& outcome, const char* message) {
    EXPECT_EQ(outcome.status, 128 + SIGTERM);
    expectOneLine(outcome.err);
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome.err;
  }

  Strings with(const Strings& more) const {
    Strings all = command_;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  /// Kills builds until the given number is killed. Each build is killed at a random moment within the
  /// duration of an undisturbed build; resumed builds are killed too. Every sixth build may finish, so that
  /// some builds finish even on a slow machine. A finished build must have written the same bytes and no
  /// other file.
  /// @return number of builds that continued a killed build.
  int killMany(int kills, uint32_t seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0, 1);
    const std::vector<Strings> resources{{"--threads", "2"}, {"--threads", "1", "--memory", "4MB"}};
    int resumed = 0;
    Strings resume;
    bool is_let_end = false;
    for (int killed = 0; killed < kills || !resume.empty();) {
      Strings more = resources[random() % resources.size()];
      more.insert(more.end(), resume.begin(), resume.end());
      Program program("lodestreamd", with(more));
      if (!is_let_end) {
        std::this_thread::sleep_for(part(random) * undisturbed_);
        program.signal(SIGKILL);
      }
      const Outcome outcome = program.wait();
      if (outcome.status == kKilled) {
        is_let_end = ++killed % 5 == 0;
        resume = {"--resume"};
        continue;
      }
      EXPECT_EQ(outcome.status, 0) << outcome.err;
      if (outcome.status != 0) return resumed;
      if (!Json::parse(outcome.out)["resumed_from"].is_null()) ++resumed;
      expectDone();
      if (HasFailure()) return resumed;
      resume.clear();
      is_let_end = false;
    }
    return resumed;
  }

  void expectDone() const {
    EXPECT_TRUE(readBytes(output_) == expected_) << "other bytes than those of an undisturbed build";
    std::filesystem::remove(output_);
    EXPECT_EQ(folder_.contents(), before_);
  }

  /// Starts a build, and sends a signal when the journal has recorded the scan. @return the outcome of the
  /// build.
  Outcome signalAfterScan(const Strings& more, int signal) const {
    const auto journal = folder_ / ".a.lode.building/journal";
    const auto bytes = [&] {
      std::error_code none;
      const auto size = std::filesystem::file_size(journal, none);
      return none ? 0 : size;
    };
    Program program("lodestreamd", with(more));
    const auto deadline = Clock::now() + std::chrono::seconds(300);
    constexpr uintmax_t kBytesOfScanned = 500;
    while (bytes() < kBytesOfScanned && Clock::now() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    program.signal(signal);
    return program.wait();
  }

  WorkFolder folder_;
  const std::string input_ = folder_ / "a.ply", output_ = folder_ / "a.lode";
  Strings command_;
  std::chrono::duration<double> undisturbed_{};
  std::string expected_;
  Strings before_;
};

TEST_F(ResumedBuild, givesTheSameBytesAndLeavesNothingAfterFiftyKillsAtRandomMoments) {
  makeModel(60000, 1024);
  EXPECT_GT(killMany(50, 1), 2) << "too few of them went on from something";
}

TEST_F(ResumedBuild, isRefusedAfterAChangeOfInputOrOptionsAndContinuesWithTheOld) {
  makeModel(60000, 1024);
  ASSERT_EQ(signalAfterScan({}, SIGKILL).status, kKilled);
  expectFailure(lodestreamd(with({"--resume", "--simplifier", "cluster"})), {"--simplifier collapse"});
  Strings other = with({"--resume"});
  *std::find(other.begin(), other.end(), "1024") = "1025";
  expectFailure(lodestreamd(other), {"--triangles-per-node 1024"});

  const std::string bytes = readBytes(input_);
  const auto time = std::filesystem::last_write_time(input_);
  std::string changed = bytes;
  changed[bytes.size() / 2] ^= 1;
  writeBytes(input_, changed);
  std::filesystem::last_write_time(input_, time);
  expectFailure(lodestreamd(with({"--resume"})), {"input has changed", "build without --resume"});

  writeBytes(input_, bytes);
  std::filesystem::last_write_time(input_, time);
  const Outcome resumed = lodestreamd(with({"--resume"}));
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_TRUE(Json::parse(resumed.out)["resumed_from"].is_string());
  expectDone();
}

TEST_F(ResumedBuild, restartsAfterAChangeIfAskedTo) {
  makeModel(60000, 1024);
  const Strings restart = with({"--resume", "--restart-if-changed"});
  const auto resumedFrom = [](const Outcome& done) { return Json::parse(done.out)["resumed_from"]; };
  ASSERT_EQ(signalAfterScan({}, SIGKILL).status, kKilled);
  Strings other = restart;
  *std::find(other.begin(), other.end(), "1024") = "1025";
  const Outcome changed = lodestreamd(other);
  ASSERT_EQ(changed.status, 0) << changed.err;
  EXPECT_TRUE(resumedFrom(changed).is_null());

  ASSERT_EQ(signalAfterScan({}, SIGKILL).status, kKilled);
  const Outcome same = lodestreamd(restart);
  ASSERT_EQ(same.status, 0) << same.err;
  EXPECT_TRUE(resumedFrom(same).is_string());
  expectDone();

  ASSERT_EQ(signalAfterScan({}, SIGKILL).status, kKilled);
  writeBytes(folder_ / ".a.lode.building/journal", "damaged");
  const Outcome damaged = lodestreamd(restart);
  ASSERT_EQ(damaged.status, 0) << damaged.err;
  EXPECT_TRUE(resumedFrom(damaged).is_null());
  expectDone();
}

TEST_F(ResumedBuild, keepsItsWorkOnASignalOnlyWithResume) {
  makeModel(60000, 1024);
  const Outcome plain = signalAfterScan({}, SIGTERM);
  expectEndBySigterm(plain, "interrupted; nothing was written");
  EXPECT_EQ(folder_.contents(), before_);

  const Outcome kept = signalAfterScan({"--resume"}, SIGTERM);
  expectEndBySigterm(kept, "finished work is kept");
  EXPECT_NE(folder_.contents(), before_);
  ASSERT_EQ(lodestreamd(with({"--resume"})).status, 0);
  expectDone();
}

TEST_F(ResumedBuild, finishesItsStoreIfTheReaderOfItsProgressIsGone) {
  makeModel(20000, 1024);
  Strings words{"-c", "set -o pipefail; \"$@\" --json-progress | head -c 1 > /dev/null", "bash",
                LODE_BIN_DIR "/bin/lodestreamd"};
  std::ranges::copy_if(command_, std::back_inserter(words),
                       [](const std::string& word) { return word != "--json" && word != "--quiet"; });
  const Outcome outcome = Program("bash", words).wait();
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_NE(outcome.err.find("cannot write to standard output"), std::string::npos) << outcome.err;
  expectDone();
}

TEST_F(ResumedBuild, removesTheRemainsOfAKilledBuildIfNotResumed) {
  makeModel(60000, 1024);
  ASSERT_EQ(signalAfterScan({}, SIGKILL).status, kKilled);
  EXPECT_NE(folder_.contents(), before_);
  ASSERT_EQ(lodestreamd(command_).status, 0);
  expectDone();
}

TEST_F(ResumedBuild, continuesOnceAFullDiskHasRoomAgain) {
  if (Program("unshare", {"--mount", "true"}).wait().status != 0)
    GTEST_SKIP() << "no mount namespaces on this system";
  makeModel(60000, 1024);
  const std::string disk = folder_ / "disk";
  std::filesystem::create_directory(disk);
  std::string build = "'" LODE_BIN_DIR "/bin/lodestreamd'";
  for (const std::string& word : with({"--resume", "--tmp", disk})) build += " '" + word + "'";
  const std::string script = "mount -t tmpfs -o size=2m tmpfs '" + disk + "'; " + build +
                             "; test $? = 1 || exit 3; mount -o remount,size=500m '" + disk + "'; " + build;
  const Outcome outcome = Program("unshare", {"--mount", "sh", "-c", script}).wait();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  expectOneLine(outcome.err);
  EXPECT_NE(outcome.err.find("the disk is full"), std::string::npos) << outcome.err;
  EXPECT_TRUE(Json::parse(outcome.out)["resumed_from"].is_string()) << outcome.out;
  std::filesystem::remove(disk);
  expectDone();
}

using SlowResumedBuild = ResumedBuild;

TEST_F(SlowResumedBuild, givesTheSameBytesAfterTwoHundredKills) {
  makeModel(400000, 4096);
  EXPECT_GT(killMany(200, 2), 20);
}

}  // namespace
}  // namespace lode::test
