// A build ends early, and another one resumes from the files that it left.

#include <chrono>
#include <fstream>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/disk/build_folder.h"
#include "server/ingest/disk/journal.h"
#include "server/ingest/pipeline/build.h"
#include "server/sample/sample.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/textures/image_files.h"

namespace lode::ingest {
namespace {

using test::kMega;
using test::readBytes;

class Resume : public testing::Test {
 protected:
  void SetUp() override {
    SampleOptions sample;
    sample.kind = "asteroid";
    sample.triangles = 20000;
    sample.attributes.bits = AttributeSet::kColour;
    writeSample(sample, folder_ / "a.ply");
    options_.input = folder_ / "a.ply";
    options_.output = folder_ / "a.lode";
    options_.triangles_per_node = 512;
    options_.memory_bytes = 2 * kMega;  // small enough to sort on disk
    options_.threads = 2;
    options_.resume = true;
    before_ = folder_.contents();
    build(options_);
    expected_ = readBytes(options_.output);
    std::filesystem::remove(options_.output);
  }

  /// Replaces the model by one with a texture image.
  void makeTextured() const {
    std::filesystem::remove(options_.input);
    test::writeBytes(folder_ / "a.png", test::pngOf(test::makePhoto(300, 200)));
    std::ofstream(options_.input) << "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 4\n"
                                     "property float x\nproperty float y\nproperty float z\n"
                                     "property float s\nproperty float t\n"
                                     "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                                     "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n3 0 1 2\n3 0 2 3\n";
  }

  /// Builds until the n-th progress report of a stage. @return whether it was reached.
  bool interruptAt(const BuildOptions& options, std::string_view stage, int n) const {
    try {
      build(options, [&](std::string_view now, double, uint64_t, uint64_t) {
        if (now == stage && --n == 0) throw Error(ErrorCode::kIo, "asked to end");
      });
    } catch (const Error& error) {
      message_ = error.what();
      return true;
    }
    return false;
  }

  std::string failure(const BuildOptions& options) const {
    try {
      build(options);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }

  /// Leaves a complete store and the journal of its finished build.
  void completeButForTheJournal() const {
    ASSERT_TRUE(interruptAt(options_, "pack", 1));
    const auto building = folder_ / ".a.lode.building";
    const auto kept = folder_ / "kept";
    build(options_, [&](std::string_view stage, double, uint64_t, uint64_t) {
      if (stage == "pack" && !std::filesystem::exists(kept))
        std::filesystem::create_hard_link(building / "journal", kept);
    });
    std::filesystem::create_directory(building);
    std::filesystem::rename(kept, building / "journal");
  }

  void expectDone() const {
    EXPECT_TRUE(readBytes(options_.output) == expected_);
    std::filesystem::remove(options_.output);
    EXPECT_EQ(folder_.contents(), before_);
  }

  test::WorkFolder folder_;
  BuildOptions options_;
  std::vector<std::string> before_;
  std::string expected_;
  mutable std::string message_;
};

TEST_F(Resume, givesTheSameBytesAfterAnInterruptionInEachStage) {
  for (const auto& [stage, resumed_from] : {std::pair{"scan", ""},
                                            {"dereference", "dereference"},
                                            {"partition", "partition"},
                                            {"simplify", "simplify"},
                                            {"pack", "pack"}}) {
    ASSERT_TRUE(interruptAt(options_, stage, 1)) << stage;
    EXPECT_FALSE(std::filesystem::exists(options_.output));
    EXPECT_EQ(build(options_).resumed_from, resumed_from);
    expectDone();
  }
}

TEST_F(Resume, givesTheSameBytesOfAModelWithTextures) {
  makeTextured();
  before_ = folder_.contents();
  build(options_);
  expected_ = readBytes(options_.output);
  std::filesystem::remove(options_.output);
  for (const auto& [stage, resumed_from] :
       {std::pair{"textures", "textures"}, {"dereference", "dereference"}, {"pack", "pack"}}) {
    ASSERT_TRUE(interruptAt(options_, stage, 1)) << stage;
    EXPECT_EQ(build(options_).resumed_from, resumed_from);
    expectDone();
  }
}

TEST_F(Resume, takesNoTriangleTwiceFromAPartlyWrittenBatch) {
  using Clock = std::chrono::steady_clock;
  int blocks = 0;
  const auto endInSecondBlock = [&](std::string_view stage, double, uint64_t, uint64_t) {
    if (stage != "dereference") return;
    if (++blocks == 2) throw Error(ErrorCode::kIo, "asked to end");
    for (const auto begin = Clock::now(); !CheckpointClock(begin).isDue(Clock::now());) continue;
  };
  EXPECT_THROW(build(options_, endInSecondBlock), Error);
  EXPECT_EQ(build(options_).resumed_from, "dereference");
  expectDone();
}

TEST_F(Resume, isRefusedIfATextureImageChanged) {
  makeTextured();
  for (const char* stage : {"textures", "simplify"}) {
    ASSERT_TRUE(interruptAt(options_, stage, 1)) << stage;
    const auto kept = folder_.contents();
    std::filesystem::rename(folder_ / "a.png", folder_ / "former.png");
    test::writeBytes(folder_ / "a.png", test::pngOf(test::makePhoto(200, 300)));
    EXPECT_NE(failure(options_).find("the texture image 'a.png' has changed since"), std::string::npos);
    std::filesystem::rename(folder_ / "former.png", folder_ / "a.png");
    EXPECT_EQ(folder_.contents(), kept);
    EXPECT_EQ(build(options_).resumed_from, stage) << "with the former one again";
    std::filesystem::remove(options_.output);
  }
}

TEST_F(Resume, isRefusedWithoutMemoryForATextureImageAndContinuesWithMore) {
  makeTextured();
  before_ = folder_.contents();
  build(options_);
  expected_ = readBytes(options_.output);
  std::filesystem::remove(options_.output);
  ASSERT_TRUE(interruptAt(options_, "textures", 1));
  BuildOptions small = options_;
  small.memory_bytes = kMega / 4;
  const std::string message = failure(small);
  EXPECT_NE(message.find("'a.png' has 300 x 200 pixels"), std::string::npos);
  EXPECT_NE(message.find("run the same command with more --memory"), std::string::npos) << message;
  EXPECT_EQ(build(options_).resumed_from, "textures");
  expectDone();
}

TEST_F(Resume, givesTheSameBytesWithOtherThreadsAndMemoryInEachPart) {
  BuildOptions first = options_, second = options_;
  first.threads = 1;
  first.memory_bytes = kMega;
  second.threads = 8;
  second.memory_bytes = 1024 * kMega;
  for (const char* stage : {"dereference", "partition", "simplify"}) {
    ASSERT_TRUE(interruptAt(first, stage, 2)) << stage;
    build(second);
    expectDone();
    ASSERT_TRUE(interruptAt(second, stage, 2)) << stage;
    build(first);
    expectDone();
  }
}

TEST_F(Resume, continuesAfterRepeatedInterruptions) {
  int ends = 0;
  while (interruptAt(options_, ends % 2 == 0 ? "dereference" : "simplify", 3) && ends < 4) ++ends;
  EXPECT_GT(ends, 1);
  build(options_);
  expectDone();
}

TEST_F(Resume, buildsWhenThereIsNothingToResume) {
  EXPECT_EQ(build(options_).resumed_from, "");
  expectDone();
}

TEST_F(Resume, keepsFinishedWorkOnlyIfAskedTo) {
  ASSERT_TRUE(interruptAt(options_, "simplify", 1));
  EXPECT_NE(message_.find("asked to end; finished work is kept"), std::string::npos) << message_;
  EXPECT_GT(folder_.contents().size(), before_.size());

  BuildOptions plain = options_;
  plain.resume = false;
  ASSERT_TRUE(interruptAt(plain, "simplify", 1));
  EXPECT_EQ(message_, "asked to end");
  EXPECT_EQ(folder_.contents(), before_) << "nor does it leave what the first had kept";
}

TEST_F(Resume, keepsNothingWhenTheInputIsAtFault) {
  std::filesystem::resize_file(options_.input, 50000);
  EXPECT_NE(failure(options_), "");
  EXPECT_EQ(folder_.contents(), before_);
}

TEST_F(Resume, isRefusedWithOtherOptionsAndContinuesWithTheSame) {
  ASSERT_TRUE(interruptAt(options_, "simplify", 1));
  const auto kept = folder_.contents();
  BuildOptions other = options_;
  other.triangles_per_node = 600;
  EXPECT_NE(failure(other).find("--triangles-per-node 512"), std::string::npos);
  other = options_;
  other.simplifier = Simplifier::kCluster;
  EXPECT_NE(failure(other).find("--simplifier collapse"), std::string::npos);
  other = options_;
  other.temporary_folder = folder_ / "elsewhere";
  EXPECT_NE(failure(other).find("--tmp"), std::string::npos);
  EXPECT_EQ(folder_.contents(), kept);
  EXPECT_EQ(build(options_).resumed_from, "simplify");
  expectDone();
}

TEST_F(Resume, isRefusedWhenTheInputHasChanged) {
  ASSERT_TRUE(interruptAt(options_, "simplify", 1));
  std::filesystem::last_write_time(options_.input, std::filesystem::file_time_type::clock::now());
  EXPECT_NE(failure(options_).find("input has changed"), std::string::npos);
  options_.resume = false;
  build(options_);
  expectDone();
}

TEST_F(Resume, isRefusedInOneLineIfItsFilesAreDamaged) {
  ASSERT_TRUE(interruptAt(options_, "simplify", 1));
  std::filesystem::resize_file(folder_ / ".a.lode.building/files/leaves", 1000);
  const std::string message = failure(options_);
  EXPECT_NE(message.find("build without --resume"), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
  options_.resume = false;
  build(options_);
  expectDone();
}

TEST_F(Resume, keepsTemporaryFilesInTheGivenFolder) {
  options_.temporary_folder = folder_ / "tmp";
  std::filesystem::create_directory(options_.temporary_folder);
  before_ = folder_.contents();
  ASSERT_TRUE(interruptAt(options_, "simplify", 1));
  EXPECT_FALSE(std::filesystem::is_empty(options_.temporary_folder));
  build(options_);
  expectDone();

  // A build with another folder for temporary files also removes the old ones.
  ASSERT_TRUE(interruptAt(options_, "simplify", 1));
  options_.temporary_folder.clear();
  options_.resume = false;
  build(options_);
  expectDone();
}

TEST_F(Resume, endsAtOnceIfTheStoreIsComplete) {
  completeButForTheJournal();
  const BuildReport report = build(options_);
  EXPECT_TRUE(report.stages.empty());
  EXPECT_EQ(report.summary.bytes, expected_.size());
  expectDone();
}

TEST_F(Resume, rebuildsIfAnotherStoreReplacedTheCompleteOne) {
  completeButForTheJournal();
  BuildOptions other = options_;
  other.output = folder_ / "b.lode";
  other.triangles_per_node = 600;
  build(other);
  std::filesystem::rename(other.output, options_.output);
  EXPECT_FALSE(build(options_).stages.empty());
  expectDone();
}

TEST_F(Resume, ignoresAJournalOfAnotherVersionUnlessAskedToResume) {
  ASSERT_TRUE(interruptAt(options_, "simplify", 1));
  std::ofstream(folder_ / ".a.lode.building/journal", std::ios::binary) << "LODEJN00";
  EXPECT_NE(failure(options_).find("build without --resume"), std::string::npos);
  options_.resume = false;
  build(options_);
  expectDone();
}

TEST_F(Resume, isRefusedWhileAnotherProcessBuilds) {
  const BuildFolder other(options_.output, folder_.path());
  EXPECT_NE(failure(options_).find("another process is building it"), std::string::npos);
}

}  // namespace
}  // namespace lode::ingest
