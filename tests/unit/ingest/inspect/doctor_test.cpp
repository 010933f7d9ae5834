#include "server/ingest/inspect/doctor.h"

#include <optional>
#include <sstream>

#include "server/ingest/pipeline/build.h"
#include "tests/support/jpeg_files.h"
#include "tests/unit/ingest/ply/ply_fixture.h"
#include "tests/unit/ingest/textures/image_files.h"

namespace lode::ingest {
namespace {

DoctorReport examineFile(const std::filesystem::path& path, uint64_t memory_bytes = 256 << 20) {
  return examine({.input = path, .memory_bytes = memory_bytes, .threads = 1, .temporary_folder = {}});
}

std::string header(const std::string& vertices, const std::string& faces, const std::string& comment = "") {
  return "ply\nformat ascii 1.0\n" + comment + "element vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

/// Two triangles that share an edge, with the same orientation, and a distant one with a duplicate vertex.
const std::string kThreeTriangles = header("8", "3") +
                                    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 0\n5 5 5\n6 5 5\n9 9 9\n"
                                    "3 0 1 2\n3 4 2 3\n3 5 6 0\n";

bool mentions(const DoctorReport& report, bool is_fatal, const std::string& words) {
  return std::any_of(report.problems.begin(), report.problems.end(), [&](const auto& problem) {
    return problem.is_fatal == is_fatal && problem.text.find(words) != std::string::npos;
  });
}

TEST(Doctor, countsEdgesPiecesAndDuplicatesAfterJoiningEqualPlaces) {
  const PlyFolder folder;
  const DoctorReport report = examineFile(folder.write(kThreeTriangles));
  ASSERT_TRUE(report.topology);
  EXPECT_EQ(report.topology->duplicate_vertices, 1u);
  EXPECT_EQ(report.topology->unused_vertices, 1u);
  EXPECT_EQ(report.topology->open_edges, 7u);
  EXPECT_EQ(report.topology->non_manifold_edges, 0u);
  EXPECT_EQ(report.topology->misoriented_edges, 0u);
  EXPECT_EQ(report.topology->pieces, 1u) << "the third hangs on the others by a vertex";
  EXPECT_EQ(report.max, glm::dvec3(6, 5, 5)) << "no face uses the farthest vertex";
  EXPECT_TRUE(report.is_buildable);
}

TEST(Doctor, findsNonManifoldAndMisorientedEdges) {
  const PlyFolder folder;
  const DoctorReport report = examineFile(folder.write(
      header("6", "4") + "0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 -1 0\n1 1 0\n3 0 1 2\n3 0 1 3\n3 1 0 4\n3 1 2 5\n"));
  ASSERT_TRUE(report.topology);
  EXPECT_EQ(report.topology->non_manifold_edges, 1u);
  EXPECT_EQ(report.topology->misoriented_edges, 1u);
}

TEST(Doctor, countsTrianglesThatTheLatticeLosesButNotFlatOnes) {
  const PlyFolder folder;
  const DoctorReport report = examineFile(folder.write(
      header("5", "3") + "0 0 0\n1000 0 0\n0 1000 0\n1e-5 1e-5 0\n0 0 0\n3 0 1 2\n3 0 3 1\n3 0 4 2\n"));
  ASSERT_TRUE(report.topology);
  EXPECT_EQ(report.topology->lost_triangles, 1u);
  EXPECT_EQ(report.topology->flat_faces, 1u);
  EXPECT_TRUE(mentions(report, false, "1 triangle with corners less than"));
}

TEST(Doctor, countsFacesWhoseNormalsPointToTheirBack) {
  const PlyFolder folder;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\nelement face 2\n"
      "property list uchar int vertex_indices\nend_header\n";
  const DoctorReport report = examineFile(folder.write(
      head +
      "0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 -1\n5 0 0 0 0 -1\n6 0 0 0 0 -1\n5 1 0 0 0 1\n3 0 1 2\n3 3 4 5\n"));
  ASSERT_TRUE(report.topology);
  EXPECT_EQ(report.topology->opposed_faces, 1u);
  EXPECT_TRUE(mentions(report, false, "1 face whose normals"));
}

TEST(Doctor, saysWhereEveryBadValueIs) {
  const PlyFolder folder;
  const DoctorReport report = examineFile(folder.write(
      header("5", "4") + "0 0 0\n1 0 0\n0 1 0\nnan 0 0\n1 1 1\n3 0 1 2\n3 0 1 9\n3 1 2 1\n3 0 2 4\n"));
  EXPECT_FALSE(report.is_buildable);
  EXPECT_TRUE(report.is_readable);
  EXPECT_TRUE(mentions(report, true, "vertex 3 at line 13: its position is NaN or infinite"));
  EXPECT_TRUE(mentions(report, true, "face 1 at line 16: there is no vertex 9"));
  EXPECT_TRUE(mentions(report, false, "face 2 at line 17: it uses a vertex twice"));
  EXPECT_TRUE(report.forecast) << "of a build with --skip-bad";
}

TEST(Doctor, showsTheFirstFewDefectsAndCountsTheOthers) {
  const PlyFolder folder;
  std::string text = header("3", "1000") + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  for (int i = 1; i < 1000; ++i) text += "3 0 1 7\n";
  const DoctorReport report = examineFile(folder.write(text));
  EXPECT_LT(report.problems.size(), 10u);
  EXPECT_TRUE(mentions(report, true, "994 more"));
}

TEST(Doctor, reportsATruncatedFileAsUnbuildable) {
  const PlyFolder folder;
  const DoctorReport report = examineFile(folder.write(header("3", "1") + "0 0 0\n1 0 0\n"));
  EXPECT_TRUE(report.header);
  EXPECT_FALSE(report.is_readable);
  EXPECT_TRUE(mentions(report, true, "truncated"));
  EXPECT_FALSE(report.forecast);
}

TEST(Doctor, countsTheReadablePartIfTheHeaderPromisesMore) {
  const PlyFolder folder;
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = tetrahedron();
    for (const char* name : {"nx", "ny", "nz"}) source.elements[0].properties.push_back({name, "float", ""});
    for (auto& row : source.elements[0].rows) row.insert(row.end(), {{0}, {0}, {1}});
    const std::string whole = source.encode(encoding);
    for (const char* faces : {"face 5", "face 5000"}) {  // the second count is refused before any row is read
      std::string bytes = whole;
      const DoctorReport report = examineFile(folder.write(bytes.replace(bytes.find("face 4"), 6, faces)));
      EXPECT_FALSE(report.is_readable);
      EXPECT_TRUE(mentions(report, true, "truncated"));
      EXPECT_EQ(report.counts.vertices, 4u);
      EXPECT_EQ(report.counts.faces, 4u);
      EXPECT_EQ(report.counts.triangles, 4u);
      EXPECT_TRUE(report.attributes.has(AttributeSet::kNormal));
    }
    std::string bytes = whole;
    bytes.resize(bytes.find("end_header") + (encoding == PlyEncoding::kAscii ? 40 : 70));
    EXPECT_EQ(examineFile(folder.write(bytes)).counts.vertices, 2u);
  }
}

TEST(Doctor, refusesTheInputsThatABuildRefuses) {
  const PlyFolder folder;
  EXPECT_FALSE(examineFile(folder.write("no ply at all")).is_readable);
  EXPECT_FALSE(examineFile(folder.write(header("3", "1") + "0 0 0\n1 0 0\n0 1 0\n3 0 0 1\n")).is_readable)
      << "no face is left";
  EXPECT_FALSE(examineFile(folder.write(header("3", "1") + "2 2 2\n2 2 2\n2 2 2\n3 0 1 2\n")).is_readable)
      << "all at one place";
}

/// A row of squares of two triangles; `fine` of them are too small for the model's lattice.
std::string rowOfSquares(int coarse, int fine) {
  std::string vertices, faces;
  int first = 0;
  const auto addRow = [&](int squares, double side) {
    for (int i = 0; i <= squares; ++i)
      for (const int y : {0, 1})
        vertices += std::to_string(i * side) + " " + std::to_string(y * side) + " 0.25\n";
    for (int i = 0; i < squares; ++i, first += 2) {
      const auto at = [&](int corner) { return " " + std::to_string(first + corner); };
      faces += "3" + at(0) + at(2) + at(1) + "\n3" + at(1) + at(2) + at(3) + "\n";
    }
    first += 2;
  };
  addRow(coarse, 1e6);
  addRow(fine, 1e-3);
  return header(std::to_string(first), std::to_string(2 * (coarse + fine))) + vertices + faces;
}

TEST(Doctor, refusesAModelOfWhichTheLatticeLosesMostAsABuildDoes) {
  const PlyFolder folder;
  const std::filesystem::path input = folder.write(rowOfSquares(10, 11));
  const DoctorReport report = examineFile(input);
  EXPECT_FALSE(report.is_readable);
  EXPECT_FALSE(report.forecast);
  const std::string words = "22 of 42 triangles would be lost", box = "[0, 0, 0.25] to [1e+07, 1e+06, 0.25]";
  EXPECT_TRUE(mentions(report, true, words));
  EXPECT_TRUE(mentions(report, true, box)) << "as the file has it, not the lattice";
  BuildOptions options;
  options.input = input;
  options.output = folder / "a.lode";
  try {
    build(options);
    ADD_FAILURE() << "built";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    expectMentions(error.what(), {words, box, "stray"});
  }
}

TEST(Doctor, forecastsAStoreOfTheTrianglesThatTheLatticeLeaves) {
  const PlyFolder folder;
  BuildOptions options;
  options.input = folder.write(rowOfSquares(500, 450));
  options.output = folder / "a.lode";
  const DoctorReport report = examineFile(options.input);
  EXPECT_TRUE(mentions(report, false, "a build drops 900 triangles with corners"));
  ASSERT_TRUE(report.forecast);
  const auto bytes = static_cast<double>(build(options).summary.bytes);
  EXPECT_NEAR(static_cast<double>(report.forecast->store_bytes), bytes, 0.1 * bytes);
}

TEST(Doctor, refusesCoordinatesThatNoLatticeHolds) {
  const PlyFolder folder;
  for (const std::string size : {"1e-310", "1e-40", "1e40", "1e300"}) {
    std::string text = header("3", "1");
    text.append("0 0 0\n").append(size).append(" 0 0\n0 ").append(size).append(" 0\n3 0 1 2\n");
    for (size_t at = 0; (at = text.find("float", at)) != std::string::npos;) text.replace(at, 5, "double");
    const DoctorReport report = examineFile(folder.write(text));
    EXPECT_FALSE(report.is_readable) << size;
    EXPECT_TRUE(mentions(report, true, "the coordinates are too small or too large to store")) << size;
    EXPECT_FALSE(report.forecast) << size;
  }
}

TEST(Doctor, looksForTexturesBesideTheFile) {
  const PlyFolder folder;
  folder.write("not looked into", "here.png");
  const DoctorReport report = examineFile(
      folder.write(header("3", "1", "comment TextureFile here.png\ncomment TextureFile gone.png\n") +
                   "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
  ASSERT_EQ(report.textures.size(), 2u);
  EXPECT_FALSE(report.textures[0].path.empty());
  EXPECT_TRUE(report.textures[1].path.empty());
  EXPECT_TRUE(mentions(report, false, "gone.png"));
  EXPECT_TRUE(report.is_buildable);
}

TEST(Doctor, saysWhichImageAPathOfAnotherMachineMeans) {
  const PlyFolder folder;
  folder.write("not looked into", "here.png");
  const DoctorReport report = examineFile(folder.write(
      "ply\nformat ascii 1.0\ncomment TextureFile C:\\scan\\HERE.png\nelement vertex 3\n"
      "property float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n"));
  ASSERT_EQ(report.textures.size(), 1u);
  EXPECT_EQ(report.textures[0].path.filename(), "here.png");
}

TEST(Doctor, reportsWhatABuildDoesWithTextureImages) {
  const PlyFolder folder;
  const auto examined = [&](const std::string& images) {
    return examineFile(folder.write("ply\nformat ascii 1.0\n" + images +
                                    "element vertex 3\nproperty float x\nproperty float y\n"
                                    "property float z\nproperty float s\nproperty float t\n"
                                    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                                    "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n"));
  };
  const std::filesystem::path text = folder.write("no picture", "text.png");
  test::writeBytes(text.parent_path() / "huge.png", test::pngHeader(60000, 60000));
  test::writeBytes(text.parent_path() / "good.png", test::pngOf(test::makePhoto(900, 900)));
  const DoctorReport large = examined("comment TextureFile huge.png\n");
  EXPECT_TRUE(mentions(large, true, "'huge.png' has 60000 x 60000 pixels"));
  EXPECT_FALSE(large.is_buildable);
  const DoctorReport without = examined("comment TextureFile text.png\n");
  EXPECT_TRUE(mentions(without, false, "'text.png' is not a JPEG, PNG or WebP image"));
  EXPECT_TRUE(without.is_buildable);
  const DoctorReport with = examined("comment TextureFile good.png\n");
  ASSERT_TRUE(with.forecast && without.forecast);
  EXPECT_TRUE(with.problems.empty());
  EXPECT_GT(with.forecast->store_bytes, without.forecast->store_bytes + 5000);
  EXPECT_GT(with.forecast->temporary_bytes, without.forecast->temporary_bytes + 5000);
  EXPECT_GT(with.forecast->memory_bytes, without.forecast->memory_bytes + 900 * 900 * 4);

  std::string many;
  for (int i = 0; i < 5000; ++i) many += "comment TextureFile good.png\n";
  const DoctorReport refused = examined(many);
  EXPECT_FALSE(refused.is_buildable);
  EXPECT_TRUE(mentions(refused, true, "5000 texture files"));
}

TEST(Doctor, reportsTheDamagedTextureImagesThatABuildReports) {
  const PlyFolder folder;
  BuildOptions options;
  options.input = folder.write(
      "ply\nformat ascii 1.0\ncomment TextureFile cut.png\ncomment TextureFile cut.jpg\n"
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float s\n"
      "property float t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n");
  options.output = folder / "a.lode";
  for (auto [name, file] : {std::pair("cut.png", test::pngOf(test::makePhoto(300, 300))),
                            std::pair("cut.jpg", test::jpegOf(test::makePhoto(300, 300)))}) {
    file.resize(file.size() / 2);
    test::writeBytes(folder / name, file);
  }
  const std::vector<std::string> warnings = build(options).warnings;
  ASSERT_EQ(warnings.size(), 2u);
  const DoctorReport report = examineFile(options.input);
  EXPECT_TRUE(report.is_buildable);
  ASSERT_EQ(report.problems.size(), 2u);
  EXPECT_TRUE(mentions(report, false, "'cut.png' is a damaged PNG"));
  EXPECT_TRUE(mentions(report, false, "; a build continues without it"));
  EXPECT_TRUE(mentions(report, false, warnings[1])) << warnings[1];
}

TEST(Doctor, countsTopologyInWhateverMemory) {
  const PlyFolder folder;
  const DoctorReport report = examineFile(folder.write(kThreeTriangles), 200);
  ASSERT_TRUE(report.topology);
  EXPECT_EQ(report.topology->open_edges, 7u);
  EXPECT_EQ(report.topology->pieces, 1u);
  EXPECT_TRUE(report.is_buildable);
}

/// Returns the number after `name=` in a manifest's topology. If there are two, returns the one with
/// duplicates merged.
std::optional<uint64_t> numberOf(const std::string& topology, const std::string& name) {
  const std::string counts = topology.substr(0, topology.find("||"));
  const size_t at = counts.rfind(name + "=");
  if (at == std::string::npos) return std::nullopt;
  return std::stoull(counts.substr(at + name.size() + 1));
}

TEST(Doctor, agreesWithTheManifestOfTheTestData) {
  const char* folder = std::getenv("LODESTREAM_TEST_DATA");
  if (folder == nullptr) GTEST_SKIP() << "set LODESTREAM_TEST_DATA to the folder with MANIFEST.tsv";
  std::ifstream file(std::filesystem::path(folder) / "MANIFEST.tsv");
  size_t checked = 0;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, '\t');) cells.push_back(cell);
    if (cells.size() < 13 || !cells[12].starts_with("accept") || !numberOf(cells[8], "bnd")) continue;
    SCOPED_TRACE(cells[0]);
    const DoctorReport report = examineFile(std::filesystem::path(folder) / cells[0]);
    if (!report.topology || report.counts.dropped_faces > 0) continue;
    EXPECT_EQ(report.topology->open_edges, numberOf(cells[8], "bnd"));
    EXPECT_EQ(report.topology->pieces, numberOf(cells[8], "comps"));
    EXPECT_EQ(report.topology->duplicate_vertices, numberOf(cells[8], "dupvert"));
    EXPECT_EQ(report.topology->unused_vertices, numberOf(cells[8], "unref"));
    if (numberOf(cells[8], "degen") == 0u) {
      EXPECT_EQ(report.topology->non_manifold_edges, numberOf(cells[8], "nonman"));
    }
    ++checked;
  }
  EXPECT_GE(checked, 20u);
}

TEST(Doctor, saysWhichPropertiesABuildLeavesOut) {
  const PlyFolder folder;
  const DoctorReport report = examineFile(folder.write(
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property float confidence\nelement face 1\nproperty list uchar int vertex_indices\n"
      "end_header\n0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n"));
  EXPECT_EQ(report.skipped_properties, std::vector<std::string>{"vertex 'confidence'"});
  EXPECT_TRUE(mentions(report, false, "vertex 'confidence'; a build leaves them out"));
  EXPECT_TRUE(report.is_buildable);
}

}  // namespace
}  // namespace lode::ingest
