#include "server/ingest/soup/scan.h"

#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

/// Makes a triangle with texture coordinates from 0 to `used`, and an unused vertex with `stray`.
std::string triangleWithStray(const std::string& used, const std::string& stray) {
  return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "property float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\n"
         "end_header\n0 0 0 0 0\n9 9 9 " +
         stray + " 0\n1 0 0 " + used + " 0\n0 1 0 0 1\n3 0 2 3\n";
}

class ScannedUv : public testing::Test {
 protected:
  UvGrid gridOf(const std::string& ply) {
    BuildOptions options;
    options.input = work_ / "a.ply";
    std::ofstream(options.input, std::ios::binary) << ply;
    const TemporaryFolder folder(work_.path());
    std::vector<std::string> warnings;
    return scan(options, folder, {}, warnings).input.uvGrid();
  }

  test::WorkFolder work_;
};

TEST_F(ScannedUv, getTheirGridFromVerticesThatFacesUse) {
  EXPECT_EQ(gridOf(triangleWithStray("1", "1000")), UvGrid());
  EXPECT_EQ(gridOf(triangleWithStray("3", "1000")), gridOf(triangleWithStray("3", "0")));
  EXPECT_EQ(gridOf(triangleWithStray("3", "0")).scale_exponent, 2);
}

TEST_F(ScannedUv, areNotRefusedForAnInvalidUnusedVertex) {
  EXPECT_EQ(gridOf(triangleWithStray("1", "1e30")), UvGrid());
}

}  // namespace
}  // namespace lode::ingest
