#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/ingest/soup/scan.h"
#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

/// A tetrahedron with colours; two vertices have a NaN value.
PlySource colouredBadly() {
  PlySource source = tetrahedron();
  for (const char* name : {"red", "green", "blue"})
    source.elements[0].properties.push_back({name, "float", ""});
  for (auto& row : source.elements[0].rows) row.insert(row.end(), {{0}, {1}, {0.5}});
  source.elements[0].rows[1][3] = {std::nan("")};
  source.elements[0].rows[2][5] = {std::nan("")};
  return source;
}

std::vector<std::string> warningsOf(const PlySource& source, PlyEncoding encoding) {
  const PlyFolder folder;
  BuildOptions options;
  options.input = folder.write(source.encode(encoding));
  options.skip_bad = true;
  std::vector<std::string> warnings;
  scan(options, TemporaryFolder(folder.path()), {}, warnings);
  return warnings;
}

TEST(ReplacedAttributes, areNotCalledLeftOut) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    const std::vector<std::string> warnings = warningsOf(colouredBadly(), encoding);
    ASSERT_EQ(warnings.size(), 1u);
    expectMentions(
        warnings[0],
        {"2 vertices or faces with a NaN or infinite colour, normal or texture coordinate", "set to 0"});
    EXPECT_EQ(warnings[0].find("skipped"), std::string::npos) << warnings[0];
  }
}

TEST(ReplacedAttributes, areCountedBesideSkippedFaces) {
  PlySource source = colouredBadly();
  source.elements[1].rows[3] = {{0, 1, 9}};
  const std::vector<std::string> warnings = warningsOf(source, PlyEncoding::kLittleEndian);
  ASSERT_EQ(warnings.size(), 2u);
  expectMentions(warnings[0], {"1 bad ", "skipped"});
  expectMentions(warnings[1], {"2 vertices", "set to 0"});
}

}  // namespace
}  // namespace lode::ingest
