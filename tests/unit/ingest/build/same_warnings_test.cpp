// What build warns of, doctor says in the same words.

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/build/build.h"
#include "server/ingest/inspect/doctor.h"
#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

class SameWarnings : public testing::Test {
 protected:
  void SetUp() override {
    options_.input = folder_ / "mesh.ply";
    options_.output = folder_ / "a.lode";
  }

  /// The one warning of a build, which doctor gives, too, and which is an error if strict.
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
    expectMentions(expectOne(), {std::to_string(row) + " bytes behind the last element, from byte " +
                                     std::to_string(bytes.size() - row),
                                 "check that the header counts all"});
  }
}

}  // namespace
}  // namespace lode::ingest
