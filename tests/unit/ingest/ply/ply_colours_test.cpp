#include <cmath>
#include <string>
#include <vector>

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
    // A list makes the reader read rows one by one, even in binary files.
    source.elements[0].properties.push_back({"bones", "int", "uchar"});
    for (auto& row : source.elements[0].rows) row.push_back({});
    if (encoding != PlyEncoding::kAscii) {
      EXPECT_EQ(readPlyBytes(source.encode(encoding)).counts.clamped_colours, vertices) << type;
    }
  }
}

TEST(PlyColours, areClampedAndCountedOutsideTheRangeOfTheirType) {
  for (const std::string type : {"float", "double"}) expectClamped(type, {0, 1, 30, -1}, 2);
  for (const std::string type : {"short", "int"}) expectClamped(type, {0, 255, 256, -1}, 2);
  expectClamped("uint", {0, 255, 256, 65535}, 2);
}

TEST(PlyColours, areAcceptedInTheRangeOfTheirType) {
  for (const std::string type : {"uchar", "short", "int", "uint"}) expectClamped(type, {0, 1, 128, 255}, 0);
  expectClamped("ushort", {0, 255, 256, 65535}, 0);
  for (const std::string type : {"float", "double"}) expectClamped(type, {-0.001, 0, 0.5, 1.001}, 0);
}

TEST(PlyColours, areCountedOncePerVertexIfClamped) {
  const PlyContent content = readPlyBytes(coloured("float", {0, 1, 30, -1}).encode(PlyEncoding::kAscii));
  EXPECT_EQ(content.vertices[2].colour, glm::u8vec4(255));
  EXPECT_EQ(content.vertices[3].colour, glm::u8vec4(0, 0, 0, 255));
}

TEST(PlyColours, causeAWarningOfScanAndDoctorIfClamped) {
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

/// Makes a tetrahedron whose faces have these values as red, green, blue and, if there are four, alpha.
PlySource withFaceColours(const std::string& type, const std::vector<std::vector<double>>& colours,
                          const std::vector<std::string>& names = {"red", "green", "blue", "alpha"}) {
  PlySource source = tetrahedron();
  PlySource::Element& faces = source.elements[1];
  for (size_t channel = 0; channel < colours[0].size(); ++channel) {
    faces.properties.push_back({names[channel], type, ""});
    for (size_t i = 0; i < 4; ++i) faces.rows[i].push_back({colours[i][channel]});
  }
  return source;
}

using Colours = std::vector<glm::u8vec4>;

void expectFaceColours(const PlySource& source, const Colours& expected) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    const PlyContent content = readPlyBytes(source.encode(encoding));
    EXPECT_EQ(content.colours, expected) << static_cast<int>(encoding);
    EXPECT_TRUE(content.attributes.has(AttributeSet::kColour));
    EXPECT_EQ(content.counts.clamped_colours, 0u);
  }
}

TEST(PlyFaceColours, areReadInEveryEncodingAndType) {
  const Colours expected{{255, 0, 0, 255}, {0, 128, 0, 255}, {0, 0, 255, 255}, {1, 2, 3, 255}};
  for (const std::string type : {"uchar", "short", "int", "uint"})
    expectFaceColours(withFaceColours(type, {{255, 0, 0}, {0, 128, 0}, {0, 0, 255}, {1, 2, 3}}), expected);
  expectFaceColours(withFaceColours("ushort", {{65535, 0, 0}, {0, 32896, 0}, {0, 0, 65535}, {257, 514, 771}}),
                    expected);
  for (const std::string type : {"float", "double"})
    expectFaceColours(
        withFaceColours(type, {{1, 0, 0}, {0, 0.5, 0}, {0, 0, 1}, {1 / 255., 2 / 255., 3 / 255.}}), expected);
}

TEST(PlyFaceColours, mayHaveAlphaAndOtherNames) {
  const std::vector<std::vector<double>> given{{255, 0, 0, 7}, {0, 128, 0, 8}, {0, 0, 255, 9}, {1, 2, 3, 10}};
  const Colours expected{{255, 0, 0, 7}, {0, 128, 0, 8}, {0, 0, 255, 9}, {1, 2, 3, 10}};
  expectFaceColours(withFaceColours("uchar", given), expected);
  expectFaceColours(
      withFaceColours("int", given, {"diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"}),
      expected);
  expectFaceColours(withFaceColours("short", given, {"r", "g", "b", "a"}), expected);
  EXPECT_TRUE(readPlyBytes(withFaceColours("uchar", given).encode(PlyEncoding::kAscii))
                  .attributes.has(AttributeSet::kAlpha));
}

TEST(PlyFaceColours, stayWithTheirFacesBesideTextureCoordinatesAndDroppedFaces) {
  PlySource source = withFaceColours("uchar", {{10, 0, 0}, {20, 0, 0}, {30, 0, 0}, {40, 0, 0}});
  PlySource::Element& faces = source.elements[1];
  faces.properties.push_back({"texcoord", "float", "uchar"});
  for (auto& row : faces.rows) row.push_back({0, 0, 1, 0, 0, 1});
  faces.rows[1][0] = {0, 1, 1};
  faces.rows[2][0] = {0, 1, 2, 3};
  faces.rows[2].back() = {0, 0, 1, 0, 1, 1, 0, 1};
  expectFaceColours(source, {{10, 0, 0, 255}, {30, 0, 0, 255}, {40, 0, 0, 255}});
}

TEST(PlyFaceColours, yieldToVertexColoursWithAWarning) {
  PlySource source = withFaceColours("uchar", {{10, 0, 0}, {20, 0, 0}, {30, 0, 0}, {40, 0, 0}});
  for (const char* name : {"red", "green", "blue"}) {
    source.elements[0].properties.push_back({name, "uchar", ""});
    for (auto& row : source.elements[0].rows) row.push_back({77});
  }
  const PlyFolder folder;
  const auto path = folder.write(source.encode(PlyEncoding::kBigEndian));
  const PlyContent content = readPly(path);
  EXPECT_TRUE(content.colours.empty());
  EXPECT_EQ(content.vertices[0].colour, glm::u8vec4(77, 77, 77, 255));
  const DoctorReport report = examine({.input = path, .temporary_folder = folder.path()});
  ASSERT_EQ(report.problems.size(), 1u);
  expectMentions(report.problems[0].text,
                 {"face 'red'", "face 'blue'", "vertices have colours, too, and these are used"});
}

TEST(PlyFaceColours, areNotReadWithoutAllThreeChannels) {
  PlySource source = withFaceColours("uchar", {{10, 0}, {20, 0}, {30, 0}, {40, 0}});
  const PlyFolder folder;
  const PlyReader reader(folder.write(source.encode(PlyEncoding::kAscii)), {});
  EXPECT_FALSE(reader.attributes().has(AttributeSet::kColour));
  EXPECT_EQ(reader.skippedProperties(), (std::vector<std::string>{"face 'red'", "face 'green'"}));
}

TEST(PlyFaceColours, areClampedAndCountedOutsideTheRangeOfTheirType) {
  const PlyFolder folder;
  const auto path = folder.write(withFaceColours("float", {{0, 0, 0}, {1, 1, 1}, {30, 225, -1}, {2, 0, 0}})
                                     .encode(PlyEncoding::kLittleEndian));
  const PlyContent content = readPly(path);
  EXPECT_EQ(content.counts.clamped_colours, 2u);
  EXPECT_EQ(content.colours[2], glm::u8vec4(255, 255, 0, 255));
  const DoctorReport report = examine({.input = path, .temporary_folder = folder.path()});
  ASSERT_EQ(report.problems.size(), 1u);
  expectMentions(report.problems[0].text, {"2 faces", "colours", "clamped"});
}

TEST(PlyFaceColours, areRefusedOrSetToZeroIfNotFinite) {
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    const PlySource source = withFaceColours("float", {{1, 1, 1}, {bad, 1, 1}, {0, 0, 0}, {0, 0, bad}});
    for (const PlyEncoding encoding : kPlyEncodings) {
      expectMentions(plyErrorOf(source.encode(encoding)),
                     {"face 1", "a colour is NaN or infinite", "--skip-bad"});
      const PlyContent content = readPlyBytes(source.encode(encoding), {.skip_bad = true});
      EXPECT_EQ(content.counts.replaced_attributes, 2u);
      EXPECT_EQ(content.counts.skipped_bad, 0u);
      ASSERT_EQ(content.colours.size(), 4u);
      EXPECT_EQ(content.colours[1], glm::u8vec4(0, 255, 255, 255));
    }
  }
}

TEST(PlyFaceColours, leaveFacesOfStripsWhite) {
  PlySource source = withFaceColours("uchar", {{10, 0, 0}, {20, 0, 0}, {30, 0, 0}, {40, 0, 0}});
  source.elements.push_back({"tristrips", {{"vertex_indices", "int", "uchar"}}, {{{0, 1, 2, 3}}}});
  const Colours white(2, glm::u8vec4(255));
  Colours expected{{10, 0, 0, 255}, {20, 0, 0, 255}, {30, 0, 0, 255}, {40, 0, 0, 255}};
  expected.insert(expected.end(), white.begin(), white.end());
  expectFaceColours(source, expected);
}

}  // namespace
}  // namespace lode::ingest
