// Normals without length, from PLY to store.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/codec/octahedral.h"
#include "common/error.h"
#include "server/ingest/inspect/against.h"
#include "server/ingest/inspect/doctor.h"
#include "server/ingest/pipeline/build.h"
#include "server/store/export.h"
#include "server/store/reader.h"
#include "tests/support/bytes.h"
#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

/// Makes a wall of side x side squares that faces x. Its first `lengthless` normals have no length, the
/// others tilt to y.
std::string wall(int side, int lengthless) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string((side + 1) * (side + 1)) +
                     "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n"
                     "property float ny\nproperty float nz\nelement face " +
                     std::to_string(side * side) + "\nproperty list uchar int vertex_indices\nend_header\n";
  for (int v = 0; v < (side + 1) * (side + 1); ++v)
    text += "0 " + std::to_string(v % (side + 1)) + " " + std::to_string(v / (side + 1)) +
            (v < lengthless ? " 0 0 0\n" : " 1 0.5 0\n");
  for (int f = 0; f < side * side; ++f) {
    const int first = f / side * (side + 1) + f % side;
    text += "4";
    for (const int corner : {first, first + 1, first + side + 2, first + side + 1})
      text += " " + std::to_string(corner);
    text += "\n";
  }
  return text;
}

class LengthlessNormals : public testing::Test {
 protected:
  BuildReport buildOf(const std::string& ply) {
    options_.input = folder_.write(ply);
    options_.output = folder_ / "a.lode";
    return build(options_);
  }

  /// Returns the normals of all vertices of the finest LODs.
  std::vector<uint16_t> storedNormals() const {
    const store::Reader reader(options_.output);
    std::vector<uint16_t> codes;
    for (const Node& node : reader.nodes())
      if (node.isLeaf())
        for (const VertexAttributes& vertex : store::readLod(reader, node, 0).vertex_attributes)
          codes.push_back(vertex.normal);
    std::sort(codes.begin(), codes.end());
    codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
    return codes;
  }

  std::vector<std::string> warningsOfDoctor() const {
    std::vector<std::string> texts;
    for (const auto& problem :
         examine({.input = options_.input, .memory_bytes = 64 << 20, .threads = 1, .temporary_folder = {}})
             .problems)
      texts.push_back(problem.text);
    return texts;
  }

  PlyFolder folder_;
  BuildOptions options_;
};

TEST_F(LengthlessNormals, areReplacedByTheNormalsOfTheFaces) {
  const BuildReport report = buildOf(wall(20, 54));
  std::vector<uint16_t> expected{encodeOctahedral({1, 0, 0}), encodeOctahedral({1, 0.5f, 0})};
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(storedNormals(), expected);
  AgainstOptions against;
  against.store = options_.output;
  against.input = options_.input;
  EXPECT_EQ(compareWithInput(against).triangles, 800u);
}

TEST_F(LengthlessNormals, areComputedWhereNoneOfTheFileHasALength) {
  buildOf(wall(20, 441));
  const AttributeSet attributes = store::Reader(options_.output).summary().attributes;
  EXPECT_TRUE(attributes.has(AttributeSet::kComputedNormal));
  const std::string expected = test::readBytes(options_.output);
  std::string without = wall(20, 441);
  const size_t at = without.find("property float nx"), end = without.find("element face");
  without.erase(at, end - at);
  for (size_t zeros; (zeros = without.find(" 0 0 0\n")) != std::string::npos;) without.erase(zeros, 6);
  buildOf(without);
  EXPECT_TRUE(test::readBytes(options_.output) == expected) << "as where a file has no normals";
}

TEST_F(LengthlessNormals, areAWarningOfBuildAndDoctorAndAnErrorIfStrict) {
  const BuildReport some = buildOf(wall(20, 54));
  ASSERT_EQ(some.warnings.size(), 1u);
  EXPECT_NE(some.warnings[0].find("54 of 441 normals have no length"), std::string::npos);
  EXPECT_EQ(warningsOfDoctor(), some.warnings);
  const BuildReport all = buildOf(wall(20, 441));
  ASSERT_EQ(all.warnings.size(), 1u);
  EXPECT_NE(all.warnings[0].find("none of its 441 normals has a length"), std::string::npos);
  EXPECT_EQ(warningsOfDoctor(), all.warnings);
  options_.strict = true;
  EXPECT_THROW(buildOf(wall(20, 54)), Error);
}

TEST_F(LengthlessNormals, doNotPointToTheBackOfAFace) {
  std::string turned = wall(1, 2);  // with reversed faces, the normals with a length point to the back
  turned.replace(turned.find("4 0 1 3 2"), 9, "4 2 3 1 0");
  options_.input = folder_.write(turned);
  const std::vector<std::string> said = warningsOfDoctor();
  EXPECT_TRUE(std::any_of(said.begin(), said.end(), [](const std::string& text) {
    return text.find("1 face whose normals") != std::string::npos;
  }));
  std::string down = wall(1, 4);
  for (size_t at = down.find("end_header"); (at = down.find("\n0 ", at)) != std::string::npos;) {
    // Turns the wall into a ceiling, whose front points down.
    std::swap(down[at + 1], down[at + 5]);
    at += 3;
  }
  options_.input = folder_.write(down);
  const std::vector<std::string> of_ceiling = warningsOfDoctor();
  ASSERT_EQ(of_ceiling.size(), 1u);
  EXPECT_NE(of_ceiling[0].find("has a length"), std::string::npos) << of_ceiling[0];
}

/// If every corner recomputed the face's normal, a face of so many corners would take hours.
TEST_F(LengthlessNormals, areSearchedOncePerFaceForAnyNumberOfCorners) {
  constexpr int kCorners = 60'000;
  std::string ply = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(kCorners) +
                    "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n"
                    "property float ny\nproperty float nz\nelement face 1\n"
                    "property list int int vertex_indices\nend_header\n";
  for (int v = 0; v < kCorners; ++v) {
    const double angle = 2 * std::numbers::pi * v / kCorners;
    ply += "0 " + std::to_string(1000 * std::cos(angle)) + " " + std::to_string(1000 * std::sin(angle)) +
           (v == 0 ? " 1 0 0\n" : " 0 0 0\n");
  }
  ply += std::to_string(kCorners);
  for (int v = 0; v < kCorners; ++v) ply += " " + std::to_string(v);
  buildOf(ply + "\n");
  EXPECT_EQ(storedNormals(), std::vector<uint16_t>{encodeOctahedral({1, 0, 0})});
}

TEST_F(LengthlessNormals, areNotCountedAtSkippedVertices) {
  std::string ply = wall(20, 0);
  ply.replace(ply.find("end_header\n0 0") + 11, 1, "nan");
  options_.skip_bad = true;
  const BuildReport report = buildOf(ply);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_EQ(report.warnings[0].find("no length"), std::string::npos) << report.warnings[0];
}

}  // namespace
}  // namespace lode::ingest
