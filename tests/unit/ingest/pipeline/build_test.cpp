#include "server/ingest/pipeline/build.h"

#include <fstream>
#include <functional>

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.h"
#include "common/limits.h"
#include "server/ingest/plan/machine.h"
#include "server/ingest/plan/memory_plan.h"
#include "server/sample/sample.h"
#include "server/store/reader.h"
#include "tests/support/bytes.h"
#include "tests/support/own_entries.h"
#include "tests/support/porous_surface.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

using test::kMega;
using test::readBytes;

class Build : public testing::Test {
 protected:
  void makeSample(uint64_t triangles, uint8_t attributes) const {
    SampleOptions sample;
    sample.kind = "asteroid";
    sample.triangles = triangles;
    sample.attributes.bits = attributes;
    writeSample(sample, folder_ / "a.ply");
  }

  BuildOptions options(const std::string& output = "a.lode") const {
    BuildOptions options;
    options.input = folder_ / "a.ply";
    options.output = folder_ / output;
    return options;
  }

  std::string built(unsigned threads, uint64_t memory_bytes, uint32_t triangles_per_node) const {
    BuildOptions given = options();
    given.threads = threads;
    given.memory_bytes = memory_bytes;
    given.triangles_per_node = triangles_per_node;
    report_ = build(given);
    return readBytes(given.output);
  }

  uint64_t temporaryBytes(const std::string& stage) const {
    for (const BuildReport::Stage& done : report_.stages)
      if (done.name == stage) return done.temporary_bytes;
    ADD_FAILURE() << "no stage " << stage;
    return 0;
  }

  test::WorkFolder folder_;
  mutable BuildReport report_;
};

TEST_F(Build, givesTheSameBytesForAnyNumberOfThreadsAndAnyMemory) {
  constexpr uint8_t kBoth = AttributeSet::kNormal | AttributeSet::kColour;
  for (const uint8_t attributes : {uint8_t{0}, kBoth}) {
    makeSample(40000, attributes);
    const std::string expected = built(1, 1024 * kMega, 1024);
    EXPECT_EQ(temporaryBytes("dereference"), 0u) << "all in memory";
    EXPECT_EQ(built(2, 1024 * kMega, 1024), expected);
    EXPECT_EQ(built(8, 1024 * kMega, 1024), expected);
    EXPECT_EQ(built(2, kMega, 1024), expected);
    EXPECT_GT(temporaryBytes("dereference"), 0u) << "sorted on disk";
  }
}

TEST_F(Build, finishesLodsOfOneNodeOnIdleThreads) {
  makeSample(100000, 0);
  BuildOptions given = options();
  given.triangles_per_node = 1 << 17;
  given.memory_bytes = 4096 * kMega;
  given.threads = 4;
  const size_t workers = given.threads + test::ownEntries("task");
  size_t most = 0;
  build(given, [&](std::string_view stage, double, uint64_t, uint64_t) {
    if (stage == "simplify") most = std::max(most, test::ownEntries("task"));
  });
  EXPECT_GT(most, workers);
}

TEST_F(Build, leavesNothingBehindWhenItFails) {
  makeSample(40000, 0);
  const auto before = folder_.contents();
  // Fails at the end, when the files of all stages exist.
  BuildOptions given = options();
  given.memory_bytes = kMega;
  EXPECT_THROW(build(given,
                     [](std::string_view stage, double, uint64_t, uint64_t) {
                       if (stage == "pack") throw Error(ErrorCode::kIo, "asked to fail");
                     }),
               Error);
  EXPECT_EQ(folder_.contents(), before);
  // Fails while reading the input.
  std::fstream input(given.input, std::ios::in | std::ios::out | std::ios::binary);
  input.seekp(-8, std::ios::end);
  input.write("\xff\xff\xff\x7f", 4);
  input.close();
  EXPECT_THROW(build(given), Error);
  EXPECT_EQ(folder_.contents(), before);
}

TEST_F(Build, endsAndClearsUpWhenProgressThrowsInTheMiddle) {
  makeSample(400000, 0);
  const auto before = folder_.contents();
  BuildOptions given = options();
  given.triangles_per_node = 1024;
  uint64_t calls = 0, done_at_last = 0, all = 0;
  EXPECT_THROW(build(given,
                     [&](std::string_view stage, double, uint64_t done, uint64_t total) {
                       if (stage != "simplify") return;
                       ++calls;
                       done_at_last = done;
                       all = total;
                       throw Error(ErrorCode::kIo, "asked to end");
                     }),
               Error);
  EXPECT_EQ(calls, 1u);
  EXPECT_LT(done_at_last, all);
  EXPECT_EQ(folder_.contents(), before);
}

TEST_F(Build, keepsTheExistingStoreWhenItFails) {
  makeSample(5000, 0);
  const std::string expected = built(1, 64 * kMega, 1024);
  std::filesystem::resize_file(folder_ / "a.ply", 1000);
  EXPECT_THROW(build(options()), Error);
  EXPECT_EQ(readBytes(folder_ / "a.lode"), expected);
}

TEST_F(Build, simplifiesOnFewerThreadsWhereMemoryIsShort) {
  EXPECT_EQ(planMemory(256 * kMega, 8, 16384).threads, 2u);
  EXPECT_EQ(planMemory(kMega, 8, 16384).threads, 1u);
  EXPECT_EQ(planMemory(4096 * kMega, 8, 16384).threads, 8u);
}

TEST(MemoryPlan, fitsAnImageIntoExactlyItsBudget) {
  for (const uint64_t image : {uint64_t{1000}, kMega, 40 * kMega, 60 * kMega, 4096 * kMega}) {
    const uint64_t budget = budgetForImage(image);
    EXPECT_GE(planMemory(budget, 8, 16384).image_bytes, image);
    EXPECT_LT(planMemory(budget - 1, 8, 16384).image_bytes, image);
    EXPECT_LT(image, budget) << "nothing is left for the program";
  }
}

TEST(MemoryPlan, encodesTilesWithAsManyThreadsAsHaveRoomBesideTheImage) {
  EXPECT_EQ(encoderThreads(4096 * kMega, 100 * kMega, 8), 8u);
  EXPECT_EQ(encoderThreads(256 * kMega, 170 * kMega, 8), 3u);
  EXPECT_EQ(encoderThreads(256 * kMega, 256 * kMega, 8), 1u);
}

TEST_F(Build, warnsIfTheMemoryLimitCannotBeKept) {
  makeSample(60000, 0);
  built(1, kMega, 16384);
  ASSERT_EQ(report_.warnings.size(), 1u);
  EXPECT_NE(report_.warnings[0].find("--memory"), std::string::npos);
}

TEST_F(Build, warnsOfTrianglesLostByTheLatticeAndRefusesThemIfStrict) {
  std::ofstream file(folder_ / "a.ply");
  file << "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\n"
          "property double y\nproperty double z\nelement face 41\n"
          "property list uchar int vertex_indices\nend_header\n"
          "0 0 0\n1000 0 0\n0 1000 0\n1e-5 1e-5 0\n3 0 3 1\n";
  for (int i = 0; i < 40; ++i) file << "3 0 1 2\n";
  file.close();
  BuildOptions given = options();
  const BuildReport report = build(given);
  EXPECT_EQ(report.summary.triangles, 40u);
  EXPECT_EQ(report.summary.dropped, 1u);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("drops 1 triangle with corners less than 0.219"), std::string::npos)
      << report.warnings[0];
  given.strict = true;
  EXPECT_THROW(build(given), Error);
}

// Builds on a small file system, mounted in a namespace of a child process. Exit status: 0: reported a full
// disk and left no files; 1: did not; 77: the system does not allow such namespaces.
int buildOnTinyDisk(BuildOptions options, const std::filesystem::path& disk) {
  const bool root = ::geteuid() == 0;
  if (::unshare(root ? CLONE_NEWNS : CLONE_NEWNS | CLONE_NEWUSER) != 0) return 77;
  if (::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return 77;
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=1m") != 0) return 77;
  try {
    build(options);
  } catch (const Error& error) {
    const bool is_clear = std::string_view(error.what()).find("disk is full") != std::string_view::npos;
    return error.code() == ErrorCode::kIo && is_clear && std::filesystem::is_empty(disk) ? 0 : 1;
  }
  return 1;
}

TEST_F(Build, saysThatTheDiskIsFullAndClearsIt) {
  makeSample(100000, 0);
  BuildOptions given = options();
  given.temporary_folder = folder_ / "disk";
  std::filesystem::create_directory(given.temporary_folder);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) ::_exit(buildOnTinyDisk(given, given.temporary_folder));
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "no mount namespaces on this system";
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_FALSE(std::filesystem::exists(given.output));
}

/// Checks I7 with more threads than the memory allows, and I6 with sorts on disk.
class SlowBuild : public Build {
 protected:
  /// Runs `work` in a child process, to keep its heaps out of this one. @return its result; 0 if it throws.
  static uint64_t inChild(const std::function<uint64_t()>& work) {
    int pipe_ends[2];
    if (::pipe(pipe_ends) != 0) return 0;
    const pid_t child = ::fork();
    if (child == 0) {
      uint64_t result = 0;
      try {
        result = work();
      } catch (const Error&) {
      }
      ::_exit(::write(pipe_ends[1], &result, sizeof result) == sizeof result ? 0 : 1);
    }
    ::close(pipe_ends[1]);
    uint64_t result = 0;
    EXPECT_EQ(::read(pipe_ends[0], &result, sizeof result), static_cast<ssize_t>(sizeof result));
    ::close(pipe_ends[0]);
    ::waitpid(child, nullptr, 0);
    return result;
  }

  void makeSample(uint64_t triangles, uint8_t attributes) const {
    inChild([&] {
      Build::makeSample(triangles, attributes);
      return triangles;
    });
  }

  void makePorousSurface(uint32_t cells, double periods) const {
    inChild([&] {
      test::PorousSurface(cells, periods).write(folder_ / "a.ply");
      return cells;
    });
  }

  /// Writes a flat square of quads.
  void makeQuads(uint32_t side) const {
    std::ofstream ply(folder_ / "a.ply", std::ios::binary);
    ply << "ply\nformat binary_little_endian 1.0\nelement vertex " << (side + 1) * (side + 1)
        << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << side * side
        << "\nproperty list uchar uint vertex_indices\nend_header\n";
    const auto put = [&](const auto& value) {
      ply.write(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (uint32_t y = 0; y <= side; ++y)
      for (uint32_t x = 0; x <= side; ++x) put(glm::vec3(x, y, 0));
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x = 0; x < side; ++x) {
        const uint32_t first = y * (side + 1) + x, above = first + side + 1;
        put(uint8_t{4});
        put(glm::uvec4(first, first + 1, above + 1, above));
      }
  }

  /// Returns the peak memory of a process that only builds.
  static uint64_t peakOfBuild(const BuildOptions& options) {
    return inChild([&] { return build(options).peak_rss_bytes; });
  }
};

TEST_F(SlowBuild, staysBelowItsMemoryOnEightThreads) {
  makeSample(700000, AttributeSet::kNormal | AttributeSet::kColour);
  BuildOptions many = options();
  many.memory_bytes = 512 * kMega;
  many.threads = 8;
  ASSERT_EQ(planMemory(many.memory_bytes, 8, many.triangles_per_node).threads, 8u);
  const uint64_t peak = peakOfBuild(many);
  EXPECT_GT(peak, 0u);
  EXPECT_LE(peak, many.memory_bytes);
}

TEST_F(SlowBuild, staysBelowLittleMemoryWithVeryManyNodes) {
  makeSample(2000000, 0);
  BuildOptions few = options("few.lode"), many = options("many.lode");
  few.memory_bytes = many.memory_bytes = 64'000'000;
  few.triangles_per_node = many.triangles_per_node = 64;
  few.threads = 1;
  many.threads = 8;
  for (const BuildOptions& given : {few, many}) {
    const uint64_t peak = peakOfBuild(given);
    EXPECT_GT(peak, 0u);
    EXPECT_LE(peak, given.memory_bytes) << given.threads << " threads";
  }
  EXPECT_TRUE(readBytes(few.output) == readBytes(many.output));
}

TEST_F(SlowBuild, dereferencesQuadsOnManyThreadsInLittleMemory) {
  makeQuads(1200);
  BuildOptions many = options();
  many.memory_bytes = 80'000'000;
  many.triangles_per_node = 512;
  many.threads = 16;
  ASSERT_EQ(planMemory(many.memory_bytes, many.threads, many.triangles_per_node).threads, many.threads);
  const uint64_t peak = inChild([&] {
    try {
      build(many, [](std::string_view stage, double, uint64_t, uint64_t) {
        if (stage == "simplify") throw Error(ErrorCode::kIo, "asked to end");
      });
    } catch (const Error&) {
    }
    return peakRssBytes();
  });
  EXPECT_GT(peak, 0u);
  EXPECT_LE(peak, many.memory_bytes);
}

TEST_F(SlowBuild, staysBelowLittleMemoryWithASurfaceThatIsAllBorders) {
  makePorousSurface(100, 5);
  for (const unsigned threads : {1u, 8u}) {
    BuildOptions given = options();
    given.memory_bytes = 96 * kMega;
    given.triangles_per_node = 512;
    given.threads = threads;
    const uint64_t peak = peakOfBuild(given);
    EXPECT_GT(peak, 0u);
    EXPECT_LE(peak, given.memory_bytes) << threads << " threads";
  }
}

TEST_F(SlowBuild, warnsIfTheRootOfAPorousModelMayExceedTheMemory) {
  makePorousSurface(80, 12);
  BuildOptions given = options();
  given.triangles_per_node = 64;
  given.memory_bytes = planMemory(0, 1, given.triangles_per_node).minimum_bytes;
  given.strict = true;
  try {
    build(given);
    ADD_FAILURE() << "no warning";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("a root of up to"), std::string::npos) << error.what();
  }
  given.memory_bytes *= 4;
  EXPECT_GT(peakOfBuild(given), 0u);
}

TEST_F(SlowBuild, staysBelowLittleMemoryWithThePorousSample) {
  SampleOptions porous;
  porous.kind = "gyroid";
  porous.triangles = 3'648'532;
  ASSERT_EQ(inChild([&] { return writeSample(porous, folder_ / "a.ply"); }), porous.triangles);
  for (const unsigned threads : {2u, 8u}) {
    BuildOptions given = options();
    given.memory_bytes = 64'000'000;
    given.triangles_per_node = 512;
    given.threads = threads;
    const uint64_t peak = peakOfBuild(given);
    EXPECT_GT(peak, 0u);
    EXPECT_LE(peak, given.memory_bytes) << threads << " threads";
  }
}

TEST_F(SlowBuild, storesNoLodAboveTheLimitButCoarserOnes) {
  makeSample(2000000, 0);
  BuildOptions large = options();
  large.triangles_per_node = 300000;
  EXPECT_NO_THROW(build(large));
  const store::Reader stored(large.output);
  for (const Node& node : stored.nodes())
    for (const Lod& lod : node.lods) EXPECT_LE(lod.triangles, kMaxLodTriangles);
}

TEST_F(SlowBuild, staysBelowItsMemoryAndGivesTheSameBytesWithMore) {
  makeSample(2500000, 0);
  BuildOptions small = options("small.lode"), large = options("large.lode");
  small.memory_bytes = 256 * kMega;
  large.memory_bytes = 4096 * kMega;
  small.threads = large.threads = 8;
  const uint64_t peak = peakOfBuild(small);
  EXPECT_GT(peak, 0u);
  EXPECT_LE(peak, small.memory_bytes);
  EXPECT_GT(peakOfBuild(large), 0u);
  EXPECT_TRUE(readBytes(small.output) == readBytes(large.output));
}

}  // namespace
}  // namespace lode::ingest
