#include "server/ingest/inspect/doctor.h"
#include "server/ingest/soup/scan.h"
#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

/// Makes a tetrahedron whose vertices have these values as red, green and blue.
PlySource coloured(const std::string& type, const std::vector<double>& values) {
  PlySource source = tetrahedron();
  for (const char* name : {"red", "green", "blue"}) {
    source.elements[0].properties.push_back({name, type, ""});
    for (size_t i = 0; i < 4; ++i) source.elements[0].rows[i].push_back({values.at(i)});
  }
  return source;
}

void expectClamped(const std::string& type, const std::vector<double>& values, uint64_t vertices) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = coloured(type, values);
    EXPECT_EQ(readPlyBytes(source.encode(encoding)).counts.clamped_colours, vertices) << type;
    source.elements[0].properties.push_back(
        {"bones", "int", "uchar"});  // rows one by one, of binary files too
    for (auto& row : source.elements[0].rows) row.push_back({});
    if (encoding != PlyEncoding::kAscii) {
      EXPECT_EQ(readPlyBytes(source.encode(encoding)).counts.clamped_colours, vertices) << type;
    }
  }
}

TEST(PlyColours, areCountedWhereTheirTypeHasNoSuchOnes) {
  for (const std::string type : {"float", "double"}) expectClamped(type, {0, 1, 30, -1}, 2);
  for (const std::string type : {"short", "int"}) expectClamped(type, {0, 255, 256, -1}, 2);
  expectClamped("uint", {0, 255, 256, 65535}, 2);
}

TEST(PlyColours, areTakenWhereTheirTypeHasThem) {
  for (const std::string type : {"uchar", "short", "int", "uint"}) expectClamped(type, {0, 1, 128, 255}, 0);
  expectClamped("ushort", {0, 255, 256, 65535}, 0);
  for (const std::string type : {"float", "double"}) expectClamped(type, {-0.001, 0, 0.5, 1.001}, 0);
}

TEST(PlyColours, areClampedOnceAVertex) {
  const PlyContent content = readPlyBytes(coloured("float", {0, 1, 30, -1}).encode(PlyEncoding::kAscii));
  EXPECT_EQ(content.vertices[2].colour, glm::u8vec4(255));
  EXPECT_EQ(content.vertices[3].colour, glm::u8vec4(0, 0, 0, 255));
}

TEST(PlyColours, areWarnedOfByScanAndDoctorWhereTheyAreClamped) {
  const PlyFolder folder;
  BuildOptions options;
  options.input = folder.write(coloured("float", {0, 1, 30, 225}).encode(PlyEncoding::kLittleEndian));
  std::vector<std::string> warnings;
  scan(options, TemporaryFolder(folder.path()), {}, warnings);
  ASSERT_EQ(warnings.size(), 1u);
  expectMentions(warnings[0], {"mesh.ply: 2 vertices", "colours", "float: 0 to 1", "others: 0 to 255"});
  const DoctorReport report = examine({.input = options.input, .temporary_folder = folder.path()});
  ASSERT_EQ(report.problems.size(), 1u);
  EXPECT_EQ(report.problems[0].text, warnings[0]);
  EXPECT_FALSE(report.problems[0].is_fatal);
}

}  // namespace
}  // namespace lode::ingest
