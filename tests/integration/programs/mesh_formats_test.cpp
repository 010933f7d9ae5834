// Checks OBJ and GLB files with an independent reader. assimp converts each file to a PLY file, which must
// contain the same triangles as the PLY file that lodestream writes.

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "programs.h"
#include "server/ingest/ply/ply_reader.h"

namespace lode::test {
namespace {

using Corner = std::array<double, 6>;  // rounded position, then rounded normal
using Triangle = std::array<Corner, 3>;

double rounded(double value, double step) { return std::round(value / step) + 0.0; }

/// Returns all triangles by value, sorted. The smallest corner of each triangle comes first.
std::vector<Triangle> trianglesOf(const std::filesystem::path& ply) {
  std::vector<Corner> corners;
  std::vector<Triangle> triangles;
  ingest::PlyReader reader(ply, {});
  reader.read(
      [&](uint64_t, std::span<const ingest::PlyVertex> vertices) {
        for (const auto& [p, normal, colour, texture] : vertices)
          corners.push_back({rounded(p.x, 1e-4), rounded(p.y, 1e-4), rounded(p.z, 1e-4),
                             rounded(normal.x, 0.05), rounded(normal.y, 0.05), rounded(normal.z, 0.05)});
      },
      [&](const ingest::PlyFaces& faces) {
        for (size_t i = 0; i + 2 < faces.corners.size(); i += 3) {
          Triangle triangle{corners.at(faces.corners[i]), corners.at(faces.corners[i + 1]),
                            corners.at(faces.corners[i + 2])};
          std::ranges::rotate(triangle, std::ranges::min_element(triangle));
          triangles.push_back(triangle);
        }
      });
  std::ranges::sort(triangles);
  return triangles;
}

bool hasAssimp() { return Program("sh", {"-c", "command -v assimp"}).wait().status == 0; }

class MeshFormats : public testing::Test {
 protected:
  void SetUp() override {
    if (!hasAssimp()) GTEST_SKIP() << "no assimp: install assimp-utils";
  }

  void expectWhatThePlyHolds(const std::string& file) const {
    const Outcome read = Program("assimp", {"export", folder_ / file, folder_ / "back.ply"}).wait();
    ASSERT_EQ(read.status, 0) << read.out << read.err;
    const std::vector<Triangle> expected = trianglesOf(folder_ / "cut.ply"),
                                found = trianglesOf(folder_ / "back.ply");
    ASSERT_GT(expected.size(), 100u);
    EXPECT_EQ(found.size(), expected.size());
    std::vector<Triangle> missing;
    std::ranges::set_difference(expected, found, std::back_inserter(missing));
    EXPECT_TRUE(missing.empty()) << missing.size() << " of " << expected.size();
  }

  WorkFolder folder_;
};

TEST_F(MeshFormats, holdTheSameTrianglesAndNormalsAfterAnExport) {
  const std::string store = makeSmallStore(folder_);
  for (const char* name : {"cut.ply", "cut.obj", "cut.glb"})
    ASSERT_EQ(lodestreamd({"export", store, "--triangles", "2000", "-o", folder_ / name}).status, 0) << name;
  expectWhatThePlyHolds("cut.obj");
  expectWhatThePlyHolds("cut.glb");
}

TEST_F(MeshFormats, holdTheSameTrianglesAfterAFetch) {
  RunningServer server({makeSmallStore(folder_)});
  for (const char* name : {"cut.ply", "cut.obj", "cut.glb"})
    ASSERT_EQ(lodestream({"fetch", server.url("small"), "-o", folder_ / name}).status, 0) << name;
  expectWhatThePlyHolds("cut.obj");
  expectWhatThePlyHolds("cut.glb");
}

TEST(StandardOutput, receivesAPlyFromExportAndFetchIfItIsAFile) {
  const WorkFolder folder;
  const std::string store = makeSmallStore(folder);
  for (const std::string& command :
       {"lodestreamd' export --error 0 " + store, "lodestream' fetch --pixels 4 --cache off " + store}) {
    SCOPED_TRACE(command);
    const auto run = [&](const std::string& output) {
      std::string line = "'" LODE_BIN_DIR "/bin/";
      line.append(command).append(" -o ").append(output);
      const Outcome outcome = Program("sh", {"-c", line}).wait();
      EXPECT_EQ(outcome.status, 0) << outcome.err;
    };
    run((folder / "named.ply").string());
    run("/dev/stdout >" + (folder / "printed").string());
    EXPECT_GT(readBytes(folder / "named.ply").size(), 1000u);
    EXPECT_TRUE(readBytes(folder / "printed") == readBytes(folder / "named.ply"));
  }
}

/// Opening the file under this name would overwrite its content.
TEST(StandardOutput, isRefusedIfItIsAppendedToOrNotEmpty) {
  const WorkFolder folder;
  const std::string store = makeSmallStore(folder), log = (folder / "log").string();
  const std::string program =
      "'" LODE_BIN_DIR "/bin/lodestreamd' export " + store + " --error 0 -o /dev/stdout";
  for (const std::string& line : {"echo before > " + log + "; " + program + " >> " + log,
                                  "{ echo before; " + program + "; } > " + log}) {
    const Outcome outcome = Program("sh", {"-c", line}).wait();
    EXPECT_EQ(outcome.status, 2) << line;
    expectOneLine(outcome.err);
    EXPECT_EQ(readBytes(folder / "log"), "before\n") << line;
  }
}

}  // namespace
}  // namespace lode::test
