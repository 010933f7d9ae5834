#include "server/ingest/inspect/doctor.h"
#include "server/ingest/soup/scan.h"
#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

/// A tetrahedron with texture coordinates, two textures and a texnumber per face.
std::string textured(const std::vector<double>& texnumbers, PlyEncoding encoding,
                     bool names_textures = true) {
  PlySource source = tetrahedron();
  for (const char* name : {"s", "t"}) source.elements[0].properties.push_back({name, "float", ""});
  for (auto& row : source.elements[0].rows) row.insert(row.end(), {{0}, {1}});
  source.elements[1].properties.push_back({"texnumber", "int", ""});
  for (size_t i = 0; i < 4; ++i) source.elements[1].rows[i].push_back({texnumbers.at(i)});
  std::string bytes = source.encode(encoding);
  if (names_textures)
    bytes.insert(bytes.find("element"), "comment TextureFile a.png\ncomment TextureFile b.png\n");
  return bytes;
}

TEST(PlyTexnumbers, areCountedWhereTheHeaderNamesNoSuchTexture) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    const PlyContent content = readPlyBytes(textured({0, 2, -2, 70000}, encoding));
    EXPECT_EQ(content.counts.unknown_textures, 3u);
    EXPECT_EQ(content.materials, (std::vector<uint16_t>{0, 2, kNoMaterial, kNoMaterial}));
  }
}

TEST(PlyTexnumbers, areNotCountedIfValidOrUnused) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    EXPECT_EQ(readPlyBytes(textured({0, 1, -1, 0}, encoding)).counts.unknown_textures, 0u);
    EXPECT_EQ(readPlyBytes(textured({0, 7, -1, 0}, encoding, false)).counts.unknown_textures, 0u)
        << "nobody looks for a texture";
  }
}

TEST(PlyTexnumbers, causeAWarningOfScanAndDoctorForUnknownTextures) {
  const PlyFolder folder;
  BuildOptions options;
  options.input = folder.write(textured({0, 1, 7, -1}, PlyEncoding::kAscii));
  std::vector<std::string> warnings;
  scan(options, TemporaryFolder(folder.path()), {}, warnings);
  ASSERT_EQ(warnings.size(), 1u);
  expectMentions(warnings[0], {"mesh.ply: 1 face with a texnumber that is neither -1 nor below 2"});
  const DoctorReport report = examine({.input = options.input, .temporary_folder = folder.path()});
  EXPECT_TRUE(std::ranges::any_of(report.problems, [&](const auto& problem) {
    return !problem.is_fatal && problem.text == warnings[0];
  }));
}

}  // namespace
}  // namespace lode::ingest
