// build and doctor give warnings in the same words.

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/inspect/doctor.h"
#include "server/ingest/pipeline/build.h"
#include "server/sample/sample.h"
#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

class SameWarnings : public testing::Test {
 protected:
  void SetUp() override {
    options_.input = folder_ / "mesh.ply";
    options_.output = folder_ / "a.lode";
  }

  /// Expects one warning from a build, the same from doctor, and an error with --strict. @return the warning.
  std::string expectOne() {
    const BuildReport report = build(options_);
    EXPECT_EQ(report.warnings.size(), 1u);
    if (report.warnings.empty()) return {};
    const DoctorReport said = examine({.input = options_.input,
                                       .memory_bytes = options_.memory_bytes,
                                       .threads = 1,
                                       .temporary_folder = {}});
    EXPECT_TRUE(std::any_of(said.problems.begin(), said.problems.end(), [&](const auto& problem) {
      return !problem.is_fatal && problem.text == report.warnings[0];
    })) << report.warnings[0];
    options_.strict = true;
    EXPECT_THROW(build(options_), Error);
    options_.strict = false;
    return report.warnings[0];
  }

  PlyFolder folder_;
  BuildOptions options_;
};

TEST_F(SameWarnings, areGivenOfBytesBehindTheLastElement) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    std::string bytes = tetrahedron().encode(encoding);
    folder_.write(bytes.replace(bytes.find("face 4"), 6, "face 3"));
    const size_t row = encoding == PlyEncoding::kAscii ? 8 : 13;
    expectMentions(expectOne(), {std::to_string(row) + " bytes after the last element, from byte " +
                                     std::to_string(bytes.size() - row),
                                 "check the counts in the header"});
  }
}

TEST_F(SameWarnings, areGivenOfAMemoryThatIsLessThanABuildTakes) {
  options_.memory_bytes = 1000000;
  SampleOptions sample;
  sample.kind = "asteroid";
  sample.triangles = 60000;
  writeSample(sample, options_.input);
  expectMentions(expectOne(), {"--memory is less than the 181MB", "16384 triangles per node"});
}

TEST_F(SameWarnings, areGivenOfAMemoryThatIsLessThanTheProgramTakes) {
  options_.memory_bytes = 10;
  folder_.write(tetrahedron().encode(PlyEncoding::kAscii));
  expectMentions(expectOne(), {"--memory is less than the 14.7MB", "the program itself"});
  options_.memory_bytes = 64 << 20;
  EXPECT_EQ(build(options_).warnings.size(), 0u);
}

}  // namespace
}  // namespace lode::ingest
