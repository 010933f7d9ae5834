// A model is edited and built again with --reuse: only what has changed is built.

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/pipeline/build.h"
#include "server/ingest/soup/former_lattice.h"
#include "server/sample/sample.h"
#include "server/store/reader.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

using test::kMega;
using test::readBytes;

void writeText(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

class Reuse : public testing::Test {
 protected:
  void SetUp() override {
    SampleOptions sample;
    sample.kind = "terrain";
    sample.triangles = 40000;
    writeSample(sample, folder_ / "a.ply");
    options_.input = folder_ / "a.ply";
    options_.output = folder_ / "a.lode";
    options_.triangles_per_node = 128;
    options_.memory_bytes = 64 * kMega;
    options_.threads = 2;
    options_.reuse_folder = folder_ / "reuse";
  }

  /// Flattens the vertices in a corner of the terrain. The sample has float coordinates only, so a vertex has
  /// 12 bytes. @return number of moved vertices.
  size_t edit(float part) const {
    std::string bytes = readBytes(options_.input);
    const size_t body = bytes.find("end_header\n") + 11;
    const size_t vertices = std::stoul(bytes.substr(bytes.find("element vertex ") + 15));
    const store::Reader store(options_.output);
    const glm::vec3 side = store.summary().lattice.toModel(store.summary().box.max);
    const glm::dvec3 origin = store.summary().lattice.origin;
    size_t moved = 0;
    for (size_t v = 0; v < vertices; ++v) {
      float at[3];
      std::memcpy(at, &bytes[body + 12 * v], sizeof at);
      if (at[0] - static_cast<float>(origin.x) > part * side.x ||
          at[1] - static_cast<float>(origin.y) > part * side.y)
        continue;
      at[2] = 0.75F * at[2] + 0.125F * side.z;
      std::memcpy(&bytes[body + 12 * v], at, sizeof at);
      ++moved;
    }
    writeText(options_.input, bytes);
    return moved;
  }

  size_t sharedFiles() const {
    return static_cast<size_t>(
        std::distance(std::filesystem::directory_iterator(options_.reuse_folder / "treelets"), {}));
  }

  test::WorkFolder folder_;
  BuildOptions options_;
};

TEST_F(Reuse, buildsNoNodeOfAModelThatHasNotChanged) {
  build(options_);
  const std::string first = readBytes(options_.output);
  const size_t files = sharedFiles();
  EXPECT_GT(files, 20u);
  size_t taken = 0, written = 0;  // treelets of the build that are, and are not, files of the shared folder
  build(options_, [&](std::string_view stage, double, uint64_t, uint64_t) {
    if (stage != "pack" || taken + written > 0) return;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / ".a.lode.building/files/treelets"))
      ++(entry.hard_link_count() > 1 ? taken : written);
  });
  EXPECT_EQ(written, 0u);
  EXPECT_EQ(taken, files);
  EXPECT_TRUE(readBytes(options_.output) == first);
  EXPECT_EQ(sharedFiles(), files);
}

TEST_F(Reuse, givesTheBytesOfABuildWithoutIt) {
  build(options_);
  const std::filesystem::path old = folder_ / "old.lode";
  for (const float part : {0.05F, 0.2F, 0.6F}) {
    std::filesystem::copy_file(options_.output, old, std::filesystem::copy_options::overwrite_existing);
    ASSERT_GT(edit(part), 10u);
    BuildOptions without = options_;
    without.reuse_folder.clear();
    without.lattice_of = old;
    without.output = folder_ / "without" / "a.lode";
    std::filesystem::create_directories(without.output.parent_path());
    build(without);
    build(options_);
    EXPECT_TRUE(readBytes(options_.output) == readBytes(without.output)) << part;
  }
}

TEST_F(Reuse, keepsTheBlobsOfWhatHasNotChanged) {
  build(options_);
  const auto digests = [&] {
    const store::Reader store(options_.output);
    std::set<Digest> found;
    for (uint32_t blob = 1; blob <= store.blobCount(); ++blob) found.insert(store.blob(blob).digest);
    return found;
  };
  const std::set<Digest> before = digests();
  const size_t files = sharedFiles();
  ASSERT_GT(edit(0.05F), 10u);
  build(options_);
  const std::set<Digest> after = digests();
  const auto kept =
      std::ranges::count_if(after, [&](const Digest& digest) { return before.contains(digest); });
  EXPECT_GT(static_cast<double>(kept), 0.8 * static_cast<double>(after.size()));
  EXPECT_LT(static_cast<double>(sharedFiles() - files), 0.2 * static_cast<double>(files))
      << "new treelets beside the old ones";
}

TEST_F(Reuse, keepsItsFolderWithinItsSize) {
  build(options_);
  uintmax_t all = 0;
  const auto bytes = [&] {
    uintmax_t sum = 0;
    for (const auto& entry : std::filesystem::directory_iterator(options_.reuse_folder / "treelets"))
      sum += entry.file_size();
    return sum;
  };
  all = bytes();
  options_.reuse_bytes = all / 2;
  build(options_);
  EXPECT_LE(bytes(), all / 2);
  EXPECT_GT(bytes(), 0u);
}

TEST_F(Reuse, survivesDamagedAndForeignFilesInItsFolder) {
  build(options_);
  const std::string first = readBytes(options_.output);
  size_t i = 0;
  for (const auto& entry : std::filesystem::directory_iterator(options_.reuse_folder / "treelets"))
    if (i++ % 2 == 0) writeText(entry.path(), std::string(i * 37, 'x'));
  writeText(options_.reuse_folder / "notes.txt", "mine");
  build(options_);
  EXPECT_TRUE(readBytes(options_.output) == first);
  EXPECT_EQ(readBytes(options_.reuse_folder / "notes.txt"), "mine");
}

TEST_F(Reuse, takesNothingOverUnderOtherOptions) {
  build(options_);
  BuildOptions other = options_;
  other.output = folder_ / "b.lode";
  other.crease_angle_deg = 20;
  BuildOptions without = other;
  without.reuse_folder.clear();
  without.output = folder_ / "without" / "b.lode";
  std::filesystem::create_directories(without.output.parent_path());
  build(other);
  build(without);
  EXPECT_TRUE(readBytes(other.output) == readBytes(without.output));
}

TEST_F(Reuse, buildsAModelThatHasGrownBeyondTheFormerLattice) {
  build(options_);
  const store::Reader before(options_.output);
  std::string bytes = readBytes(options_.input);
  const size_t body = bytes.find("end_header\n") + 11;
  const float far[3] = {-1, -1, 0};
  std::memcpy(&bytes[body], far, sizeof far);
  writeText(options_.input, bytes);
  build(options_);
  EXPECT_NE(store::Reader(options_.output).summary().lattice, before.summary().lattice);
}

TEST_F(Reuse, refusesALatticeThatDoesNotReachTheModel) {
  options_.reuse_folder.clear();
  build(options_);
  std::string bytes = readBytes(options_.input);
  const float far[3] = {-1, -1, 0};
  std::memcpy(&bytes[bytes.find("end_header\n") + 11], far, sizeof far);
  writeText(options_.input, bytes);
  BuildOptions again = options_;
  again.lattice_of = options_.output;
  again.output = folder_ / "b.lode";
  try {
    build(again);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("extends beyond the lattice of"), std::string::npos)
        << error.what();
  }
}

TEST(FormerLattice, readsBackTheErrorOfSnapping) {
  for (const double measured : {0.0, 0.1, 0.5, 0.86602, 1e-7, 3.25}) {
    const float error = errorOfSnapping(measured);
    EXPECT_GE(error, measured);
    EXPECT_LE(error, measured * 1.0001 + 1.0 / 64);
    for (const double step : {0.5, 5.0 / 1024, 0.75, 7.0 * 1048576})
      EXPECT_EQ(static_cast<float>(static_cast<float>(error * step) / step), error);
  }
}

TEST(StepOption, letsSeparatelyBuiltNeighboursMeet) {
  const test::WorkFolder folder;
  const auto write = [&](const char* name, const char* vertices) {
    writeText(folder / name, std::string("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                                         "property float y\nproperty float z\nelement face 1\n"
                                         "property list uchar int vertex_indices\nend_header\n") +
                                 vertices + "3 0 1 2\n");
    BuildOptions options;
    options.input = folder / name;
    options.output = folder / (std::string(name) + ".lode");
    options.memory_bytes = 64 * kMega;
    options.step_model = 0.3F;
    build(options);
    return store::Reader(options.output).summary().lattice;
  };
  const Lattice left = write("left", "0 0 0\n100 0 0\n100 77.7 3\n");
  const Lattice right = write("right", "100 0 0\n100 77.7 3\n100.9 50 1\n");
  EXPECT_EQ(left.step, 0.25);
  EXPECT_EQ(right.step, left.step);
  for (const glm::dvec3 shared : {glm::dvec3(100, 0, 0), glm::dvec3(100, 77.7F, 3)})
    EXPECT_EQ(left.toWorld(left.snap(shared)), right.toWorld(right.snap(shared)));
}

TEST(StepOption, isRefusedIfTheModelIsTooLargeForIt) {
  const test::WorkFolder folder;
  SampleOptions sample;
  sample.kind = "asteroid";
  sample.triangles = 1000;
  writeSample(sample, folder / "a.ply");
  BuildOptions options;
  options.input = folder / "a.ply";
  options.output = folder / "a.lode";
  options.memory_bytes = 64 * kMega;
  options.step_model = 1e-12F;
  EXPECT_THROW(build(options), Error);
}

}  // namespace
}  // namespace lode::ingest
