// Tests of lodestreamd build --part as a job scheduler runs it: parts are killed, run twice, and run at the
// same time. The store must equal the store of a whole build. See docs/cluster.md.

#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
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

constexpr int kKilled = 128 + SIGKILL, kTryAgain = 75;

class BuildInParts : public testing::Test {
 protected:
  BuildInParts() {
    EXPECT_EQ(
        lodestreamd({"sample", "asteroid", "--triangles", "60000", "--attributes", "normal", "-o", input_})
            .status,
        0);
    const auto began = Clock::now();
    EXPECT_EQ(lodestreamd({"build", input_, "-o", output_, "--triangles-per-node", "512", "--quiet"}).status,
              0);
    whole_ = Clock::now() - began;
    expected_ = readBytes(output_);
    std::filesystem::remove(output_);
    before_ = folder_.contents();
  }

  Strings command(const Strings& more) const {
    Strings all{"build", input_, "-o", output_, "--triangles-per-node", "512", "--quiet"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Strings prepare(int tasks) const {
    return command({"--part", "prepare", "--tasks", std::to_string(tasks)});
  }
  Strings task(int number, int tasks) const {
    return command({"--part", "simplify", "--task", std::to_string(number), "--tasks", std::to_string(tasks),
                    "--threads", "1"});
  }
  Strings finish(int tasks) const { return command({"--part", "finish", "--tasks", std::to_string(tasks)}); }

  static void expectSuccess(const Strings& words) {
    const Outcome outcome = lodestreamd(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
  }

  void expectDone() const {
    EXPECT_TRUE(readBytes(output_) == expected_) << "other bytes than those of a whole build";
    std::filesystem::remove(output_);
    EXPECT_EQ(folder_.contents(), before_);
  }

  /// Kills a part up to ten times, each time at a random moment, then lets it end. A part that ends before it
  /// is killed must have succeeded. @return number of killed processes.
  int killTenTimes(const Strings& words, uint32_t seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0, 1);
    int killed = 0;
    for (int i = 0; i < 10; ++i) {
      Program program("lodestreamd", words);
      std::this_thread::sleep_for(part(random) * whole_ / 3);
      program.signal(SIGKILL);
      const Outcome outcome = program.wait();
      if (outcome.status == 0) return killed;
      EXPECT_EQ(outcome.status, kKilled) << outcome.err;
      ++killed;
    }
    expectSuccess(words);
    return killed;
  }

  WorkFolder folder_;
  const std::string input_ = folder_ / "a.ply", output_ = folder_ / "a.lode";
  std::chrono::duration<double> whole_{};
  std::string expected_;
  Strings before_;
};

TEST_F(BuildInParts, givesTheSameBytesAfterKillsOfEachPart) {
  int killed = 0;
  for (int seed = 1; seed <= 2 && !HasFailure(); ++seed) {
    killed += killTenTimes(prepare(3), seed);
    for (const int number : {2, 0, 1}) killed += killTenTimes(task(number, 3), 10 * seed + number);
    killed += killTenTimes(finish(3), 100 + seed);
    expectDone();
  }
  EXPECT_GT(killed, 2) << "too few parts were killed";
}

TEST_F(BuildInParts, givesTheSameBytesIfItsTasksRunAtTheSameTimeAndTwice) {
  expectSuccess(prepare(4));
  std::vector<std::unique_ptr<Program>> running;
  for (const int number : {3, 1, 0, 2, 1, 3})
    running.push_back(std::make_unique<Program>("lodestreamd", task(number, 4)));
  for (const auto& program : running) {
    const Outcome outcome = program->wait();
    EXPECT_EQ(outcome.status, 0) << outcome.err;
  }
  expectSuccess(finish(4));
  expectDone();
}

TEST_F(BuildInParts, endsWithStatus75IfARetryMayHelp) {
  for (const Strings& words : {task(0, 2), finish(2)}) {
    const Outcome unprepared = lodestreamd(words);
    EXPECT_EQ(unprepared.status, kTryAgain);
    EXPECT_NE(unprepared.err.find("run --part prepare first"), std::string::npos) << unprepared.err;
  }
  expectSuccess(prepare(2));
  expectSuccess(task(0, 2));
  const Outcome early = lodestreamd(finish(2));
  EXPECT_EQ(early.status, kTryAgain);
  expectOneLine(early.err);
  EXPECT_NE(early.err.find("task 1 of 2 is not finished; run it again"), std::string::npos) << early.err;
  expectSuccess(task(1, 2));
  expectSuccess(finish(2));
  expectDone();
}

TEST_F(BuildInParts, endsWithStatus75IfTheDiskIsFull) {
  if (Program("unshare", {"--mount", "true"}).wait().status != 0)
    GTEST_SKIP() << "no mount namespaces on this system";
  const std::string disk = folder_ / "disk";
  std::filesystem::create_directory(disk);
  const auto run = [&](const std::string& part) {
    return "'" LODE_BIN_DIR "/bin/lodestreamd' build '" + input_ + "' -o '" + disk +
           "/a.lode' --triangles-per-node 512 --quiet --tasks 1 --part " + part;
  };
  const std::string script = "mount -t tmpfs -o size=500m tmpfs '" + disk + "'; " + run("prepare") +
                             " || exit 3; mount -o remount,size=$(($(df --output=used -k '" + disk +
                             "' | tail -1) + 64))k '" + disk + "'; " + run("simplify --task 0") +
                             "; test $? = 75 || exit 4; mount -o remount,size=500m '" + disk + "'; " +
                             run("simplify --task 0") + " && " + run("finish") + " && cp '" + disk +
                             "/a.lode' '" + output_ + "'";
  const Outcome outcome = Program("unshare", {"--mount", "sh", "-c", script}).wait();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("the disk is full"), std::string::npos) << outcome.err;
  std::filesystem::remove(disk);
  expectDone();
}

TEST_F(BuildInParts, endsWithStatus1IfNoRetryHelps) {
  expectSuccess(prepare(2));
  const Outcome other = lodestreamd(task(0, 3));
  EXPECT_EQ(other.status, 1);
  EXPECT_NE(other.err.find("prepared for --tasks 2"), std::string::npos) << other.err;
  for (const int number : {0, 1}) expectSuccess(task(number, 2));
  expectSuccess(finish(2));
  expectDone();
}

TEST_F(BuildInParts, endsWithStatus2IfTheOptionsDoNotFit) {
  for (const Strings& wrong : {Strings{"--part", "simplify", "--tasks", "2"},
                               {"--part", "simplify", "--tasks", "2", "--task", "2"},
                               {"--part", "prepare", "--tasks", "2", "--task", "0"},
                               {"--part", "prepare"},
                               {"--part", "all", "--tasks", "2"},
                               {"--part", "prepare", "--tasks", "0"},
                               {"--tasks", "2"},
                               {"--task", "2"}}) {
    const Outcome outcome = lodestreamd(command(wrong));
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    expectOneLine(outcome.err);
  }
  EXPECT_EQ(folder_.contents(), before_);
}

TEST_F(BuildInParts, succeedsIfFinishRunsAgainAfterItHasSucceeded) {
  expectSuccess(prepare(1));
  expectSuccess(task(0, 1));
  expectSuccess(finish(1));
  const Outcome again = lodestreamd(finish(1));
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_NE(again.err.find("is finished already"), std::string::npos) << again.err;
  expectDone();
}

TEST_F(BuildInParts, reportsEachPartAsJson) {
  const auto json = [&](Strings words) {
    words.emplace_back("--json");
    return Json::parse(lodestreamd(words).out);
  };
  EXPECT_EQ(json(prepare(2))["stages"].back()["name"], "partition");
  const Json task_report = json(task(0, 2));
  EXPECT_EQ(task_report["stages"][0]["name"], "simplify");
  EXPECT_FALSE(task_report.contains("triangles"));
  expectSuccess(task(1, 2));
  EXPECT_GT(json(finish(2))["triangles"], 50000);
  expectDone();
}

}  // namespace
}  // namespace lode::test
