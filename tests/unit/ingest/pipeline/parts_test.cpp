// A build in parts: prepare, tasks of simplify in any order, and finish.

#include <algorithm>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/pipeline/build.h"
#include "server/sample/sample.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/textures/image_files.h"

namespace lode::ingest {
namespace {

using test::kMega;
using test::readBytes;

class Parts : public testing::Test {
 protected:
  void SetUp() override {
    SampleOptions sample;
    sample.kind = "asteroid";
    sample.triangles = 20000;
    sample.attributes.bits = AttributeSet::kColour;
    writeSample(sample, folder_ / "a.ply");
    options_.input = folder_ / "a.ply";
    options_.output = folder_ / "a.lode";
    options_.triangles_per_node = 128;
    options_.memory_bytes = 8 * kMega;
    options_.threads = 1;
    before_ = folder_.contents();
    build(options_);
    expected_ = readBytes(options_.output);
    std::filesystem::remove(options_.output);
  }

  BuildOptions part(BuildPart part, uint32_t tasks, uint32_t task = 0) const {
    BuildOptions options = options_;
    options.part = part;
    options.tasks = tasks;
    options.task = task;
    return options;
  }
  BuildReport prepare(uint32_t tasks) const { return build(part(BuildPart::kPrepare, tasks)); }
  BuildReport simplify(uint32_t task, uint32_t tasks) const {
    return build(part(BuildPart::kSimplify, tasks, task));
  }
  BuildReport finish(uint32_t tasks) const { return build(part(BuildPart::kFinish, tasks)); }

  /// Runs all tasks in a random order.
  void simplifyAll(uint32_t tasks) const {
    std::vector<uint32_t> order(tasks);
    for (uint32_t i = 0; i < tasks; ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), std::mt19937(tasks));
    for (const uint32_t task : order) simplify(task, tasks);
  }

  /// Expects the error of a build, and that the build leaves all files as they are.
  void expectRefusal(const BuildOptions& options, ErrorCode code, const char* message) const {
    const auto kept = folder_.contents();
    try {
      build(options);
      ADD_FAILURE() << "not refused: " << message;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
    EXPECT_EQ(folder_.contents(), kept);
  }

  /// Runs a part until the n-th progress report of a stage.
  static void interruptAt(const BuildOptions& options, std::string_view stage, int n) {
    EXPECT_THROW(build(options,
                       [&](std::string_view now, double, uint64_t, uint64_t) {
                         if (now == stage && --n == 0) throw Error(ErrorCode::kIo, "asked to end");
                       }),
                 Error);
  }

  void expectDone() const {
    EXPECT_TRUE(readBytes(options_.output) == expected_) << "other bytes than those of a whole build";
    std::filesystem::remove(options_.output);
    EXPECT_EQ(folder_.contents(), before_);
  }

  test::WorkFolder folder_;
  BuildOptions options_;
  std::vector<std::string> before_;
  std::string expected_;
};

TEST_F(Parts, giveTheSameBytesForAnyNumberOfTasksInAnyOrder) {
  for (const uint32_t tasks : {1u, 3u, 16u, 200u}) {
    prepare(tasks);
    simplifyAll(tasks);
    finish(tasks);
    expectDone();
  }
}

TEST_F(Parts, giveTheSameBytesOfAModelOfOneNode) {
  options_.triangles_per_node = 1 << 16;
  build(options_);
  expected_ = readBytes(options_.output);
  std::filesystem::remove(options_.output);
  prepare(4);
  simplifyAll(4);
  finish(4);
  expectDone();
}

TEST_F(Parts, mayHaveOtherThreadsMemoryAndTemporaryFoldersEach) {
  std::filesystem::create_directory(folder_ / "scratch");
  BuildOptions first = part(BuildPart::kPrepare, 2);
  first.threads = 3;
  first.memory_bytes = 2 * kMega;
  build(first);
  BuildOptions task = part(BuildPart::kSimplify, 2, 1);
  task.temporary_folder = folder_ / "scratch";
  task.memory_bytes = kMega;
  build(task);
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "scratch"));
  std::filesystem::remove(folder_ / "scratch");
  simplify(0, 2);
  finish(2);
  expectDone();
}

TEST_F(Parts, doEachTaskOnceIfItRunsTwice) {
  prepare(3);
  simplifyAll(3);
  const auto treelets = folder_ / ".a.lode.building/files/treelets";
  const auto timesOfFiles = [&] {
    std::map<std::filesystem::path, std::filesystem::file_time_type> times;
    for (const auto& entry : std::filesystem::directory_iterator(treelets))
      times[entry.path()] = entry.last_write_time();
    return times;
  };
  const auto done = timesOfFiles();
  simplify(1, 3);
  EXPECT_EQ(timesOfFiles(), done) << "a finished treelet was written again";
  finish(3);
  expectDone();
}

TEST_F(Parts, continueATaskThatWasInterrupted) {
  prepare(2);
  interruptAt(part(BuildPart::kSimplify, 2, 0), "simplify", 2);
  simplify(0, 2);
  simplify(1, 2);
  finish(2);
  expectDone();
}

TEST_F(Parts, continueFinishAfterInterruptionsInEachStage) {
  prepare(2);
  simplifyAll(2);
  for (const char* stage : {"simplify", "pack"}) interruptAt(part(BuildPart::kFinish, 2), stage, 1);
  finish(2);
  expectDone();
}

TEST_F(Parts, runAgainFromTheBeginningWhenOnlyPackIsLeft) {
  prepare(2);
  simplifyAll(2);
  interruptAt(part(BuildPart::kFinish, 2), "pack", 1);
  prepare(2);
  simplifyAll(2);
  finish(2);
  expectDone();
}

TEST_F(Parts, areNotRemovedByAWholeBuild) {
  prepare(2);
  simplify(0, 2);
  expectRefusal(options_, ErrorCode::kInput, "is being built in parts; finish it, or delete");
  simplify(1, 2);
  finish(2);
  expectDone();
}

TEST_F(Parts, askForARetryIfTheInputCannotBeRead) {
  prepare(1);
  std::filesystem::rename(options_.input, folder_ / "away.ply");
  expectRefusal(part(BuildPart::kSimplify, 1), ErrorCode::kIo, "cannot be read; restore it");
  std::filesystem::rename(folder_ / "away.ply", options_.input);
  simplify(0, 1);
  finish(1);
  expectDone();
}

TEST_F(Parts, continuePrepareAfterAnInterruption) {
  options_.memory_bytes = 2 * kMega;  // small enough to sort on disk
  interruptAt(part(BuildPart::kPrepare, 2), "partition", 1);
  EXPECT_EQ(prepare(2).resumed_from, "partition");
  EXPECT_TRUE(prepare(2).stages.empty()) << "prepared already";
  simplifyAll(2);
  finish(2);
  expectDone();
}

TEST_F(Parts, keepFinishedWorkIfFinishBeginsTooEarly) {
  prepare(3);
  simplify(0, 3);
  simplify(2, 3);
  expectRefusal(part(BuildPart::kFinish, 3), ErrorCode::kIo, "task 1 of 3 is not finished; run it again");
  simplify(1, 3);
  finish(3);
  expectDone();
}

TEST_F(Parts, rebuildATreeletThatIsDamagedWhenFinishReadsIt) {
  prepare(3);
  simplifyAll(3);
  std::vector<std::filesystem::path> treelets;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / ".a.lode.building/files/treelets"))
    treelets.push_back(entry.path());
  ASSERT_GT(treelets.size(), 5u);
  for (size_t i = 0; i < treelets.size(); i += 2) std::filesystem::resize_file(treelets[i], 100);
  finish(3);
  expectDone();
}

TEST_F(Parts, areRefusedWithoutPreparation) {
  for (const BuildPart each : {BuildPart::kSimplify, BuildPart::kFinish})
    expectRefusal(part(each, 2), ErrorCode::kIo, "run --part prepare first");
}

TEST_F(Parts, areRefusedWhileThePreparationIsIncomplete) {
  options_.memory_bytes = 2 * kMega;
  interruptAt(part(BuildPart::kPrepare, 2), "partition", 1);
  for (const BuildPart each : {BuildPart::kSimplify, BuildPart::kFinish})
    expectRefusal(part(each, 2), ErrorCode::kIo, "--part prepare has not finished; run it again");
  std::filesystem::remove_all(folder_ / ".a.lode.building");
}

TEST_F(Parts, areRefusedWithOtherOptionsTasksOrInput) {
  prepare(2);
  simplifyAll(2);
  for (const BuildPart each : {BuildPart::kSimplify, BuildPart::kFinish}) {
    expectRefusal(part(each, 3), ErrorCode::kInput, "was prepared for --tasks 2");
    BuildOptions other = part(each, 2);
    other.triangles_per_node = 129;
    expectRefusal(other, ErrorCode::kInput, "--triangles-per-node 128; use the same, or run --part prepare");
  }
  const auto time = std::filesystem::last_write_time(options_.input);
  std::filesystem::last_write_time(options_.input, time + std::chrono::seconds(9));
  for (const BuildPart each : {BuildPart::kSimplify, BuildPart::kFinish})
    expectRefusal(part(each, 2), ErrorCode::kInput, "input has changed since it began; run --part prepare");
  std::filesystem::last_write_time(options_.input, time);
  finish(2);
  expectDone();
}

TEST_F(Parts, canBePreparedAgainWithOtherOptions) {
  prepare(2);
  simplifyAll(2);
  BuildOptions other = part(BuildPart::kPrepare, 2);
  other.triangles_per_node = 129;
  build(other);
  expectRefusal(part(BuildPart::kSimplify, 2), ErrorCode::kInput, "--triangles-per-node 129");
  prepare(2);
  simplifyAll(2);
  finish(2);
  expectDone();
}

TEST_F(Parts, leaveNothingOfAKilledTaskBehind) {
  prepare(1);
  std::filesystem::create_directories(folder_ / ".a.lode.building/files/.lodestream-build-killed");
  simplify(0, 1);
  finish(1);
  expectDone();
}

TEST_F(Parts, canBePreparedAgainForAnotherNumberOfTasks) {
  prepare(2);
  simplify(0, 2);
  prepare(5);
  simplifyAll(5);
  finish(5);
  expectDone();
}

TEST_F(Parts, doNotChangeTheFilesOfThePreparation) {
  prepare(2);
  const auto files = folder_ / ".a.lode.building/files";
  const std::string leaves = readBytes(files / "leaves"), border = readBytes(files / "border");
  const std::string journal = readBytes(folder_ / ".a.lode.building/journal");
  simplifyAll(2);
  EXPECT_TRUE(readBytes(files / "leaves") == leaves);
  EXPECT_TRUE(readBytes(files / "border") == border);
  EXPECT_TRUE(readBytes(folder_ / ".a.lode.building/journal") == journal);
  finish(2);
  expectDone();
}

}  // namespace
}  // namespace lode::ingest
