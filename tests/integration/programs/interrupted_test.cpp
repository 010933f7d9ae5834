// Tests of lodestreamd commands that a signal ends while they write. They remove partial files and report the
// signal.

#include <chrono>
#include <csignal>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/integration/programs/programs.h"

namespace lode::test {
namespace {

using Strings = std::vector<std::string>;

class InterruptedCommand : public testing::Test {
 protected:
  /// Sends a signal when the command has created a file or folder. Expects that the command removes the file
  /// or folder.
  void expectNothingLeft(const Strings& command, int signal) const {
    const Strings before = folder_.contents();
    Program program("lodestreamd", command);
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (countEntries() == before.size() && std::chrono::steady_clock::now() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    program.signal(signal);
    const Outcome outcome = program.wait();
    EXPECT_EQ(outcome.status, 128 + signal);
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find("interrupted; unfinished output is removed"), std::string::npos)
        << outcome.err;
    expectOneLine(outcome.err);
    EXPECT_EQ(folder_.contents(), before);
  }

  WorkFolder folder_;

 private:
  size_t countEntries() const {
    using Files = std::filesystem::directory_iterator;
    return static_cast<size_t>(std::distance(Files(folder_.path()), Files()));
  }
};

TEST_F(InterruptedCommand, leavesNothingOfASample) {
  expectNothingLeft({"sample", "gyroid", "--triangles", "20000000", "-o", folder_ / "x.ply"}, SIGINT);
}

TEST_F(InterruptedCommand, leavesNothingOfASampleScene) {
  expectNothingLeft({"sample", "scene", "--triangles", "100000000", "-o", folder_ / "scene"}, SIGTERM);
}

TEST_F(InterruptedCommand, leavesNothingOfASampleSceneWithAnImpossibleModel) {
  const Strings before = folder_.contents();
  const Outcome outcome = lodestreamd({"sample", "scene", "--triangles", "1000", "-o", folder_ / "scene"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("gyroid"), std::string::npos) << outcome.err;
  EXPECT_EQ(folder_.contents(), before);
}

TEST_F(InterruptedCommand, leavesNoTemporaryFolderOfADoctor) {
  const WorkFolder models;
  const std::string model = models / "a.ply";
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "1000000", "-o", model}).status, 0);
  expectNothingLeft({"doctor", model, "--tmp", folder_.path()}, SIGHUP);
}

/// Builds of a single node, which take many seconds without checking for signals.
class InterruptedBuild : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    models = std::make_unique<WorkFolder>();
    ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "600000", "-o", model()}).status, 0);
  }
  static void TearDownTestSuite() { models.reset(); }
  static std::string model() { return *models / "a.ply"; }

  /// Sends a signal to a build that has begun to simplify. Expects that the signal ends the build at once.
  Outcome interrupt(const Strings& more, int signal) const {
    Strings command{"build",   model(),          "-o", folder_ / "a.lode", "--triangles-per-node",
                    "1000000", "--json-progress"};
    command.insert(command.end(), more.begin(), more.end());
    Program program("lodestreamd", command);
    std::string line;
    do line = program.readLine();
    while (line.find("simplify") == std::string::npos && line.ends_with('\n'));
    program.signal(signal);
    const auto sent = std::chrono::steady_clock::now();
    Outcome outcome = program.wait();
    EXPECT_LT(std::chrono::steady_clock::now() - sent, kAtOnce);
    EXPECT_EQ(outcome.status, 128 + signal);
    expectOneLine(outcome.err);
    return outcome;
  }

  /// One second, plus tolerance for a busy machine.
  static constexpr std::chrono::milliseconds kAtOnce{2500};
  static inline std::unique_ptr<WorkFolder> models;
  WorkFolder folder_;
};

TEST_F(InterruptedBuild, endsAtOnceAndLeavesNothing) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const Outcome outcome = interrupt({}, signal);
    EXPECT_NE(outcome.err.find("interrupted; nothing was written"), std::string::npos) << outcome.err;
    EXPECT_TRUE(folder_.contents().empty());
  }
}

TEST_F(InterruptedBuild, removesItsTemporaryFilesInAnotherFolderToo) {
  const WorkFolder temporary;
  interrupt({"--tmp", temporary.path()}, SIGTERM);
  EXPECT_TRUE(temporary.contents().empty());
  EXPECT_TRUE(folder_.contents().empty());
}

TEST_F(InterruptedBuild, endsAtOnceAndKeepsItsWorkWithResume) {
  const Outcome outcome = interrupt({"--resume"}, SIGTERM);
  EXPECT_NE(outcome.err.find("finished work is kept"), std::string::npos) << outcome.err;
  EXPECT_FALSE(folder_.contents().empty());
}

}  // namespace
}  // namespace lode::test
