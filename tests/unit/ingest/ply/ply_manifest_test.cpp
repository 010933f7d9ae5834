#include <map>
#include <sstream>

#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

/// Reads the rows of the test data's manifest, by column name.
std::vector<std::map<std::string, std::string>> readManifest(const std::filesystem::path& folder) {
  std::ifstream file(folder / "MANIFEST.tsv");
  std::vector<std::string> names;
  std::vector<std::map<std::string, std::string>> rows;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, '\t');) cells.push_back(cell);
    if (names.empty()) {
      names = cells;
      continue;
    }
    std::map<std::string, std::string>& row = rows.emplace_back();
    for (size_t i = 0; i < cells.size(); ++i) row[names.at(i)] = cells[i];
  }
  return rows;
}

/// Returns the number after `tri=` in the manifest.
uint64_t trianglesOf(const std::string& sizes) { return std::stoull(sizes.substr(sizes.find("tri=") + 4)); }

void expectAccepted(const std::filesystem::path& path, std::map<std::string, std::string>& row) {
  const PlyContent content = readPly(path);
  EXPECT_EQ(content.counts.vertices, std::stoull(row["vertices"]));
  EXPECT_EQ(content.vertices.size(), content.counts.vertices);
  EXPECT_EQ(content.counts.faces, std::stoull(row["faces"]));
  EXPECT_EQ(content.counts.triangles, trianglesOf(row["triangles/face sizes"]));
  EXPECT_EQ(content.counts.extra_tokens, 0u);
  EXPECT_EQ(content.counts.trailing_bytes, 0u);
  for (const std::string& texture : content.header.texture_files) {
    EXPECT_TRUE(std::filesystem::exists(path.parent_path() / texture)) << texture;
  }
  const std::string& expected = row["expected"];
  if (const size_t with = expected.find("with ");
      with != std::string::npos && expected.find("texture") != std::string::npos) {
    const bool numbered = std::isdigit(static_cast<unsigned char>(expected[with + 5])) != 0;
    EXPECT_EQ(content.header.texture_files.size(), numbered ? std::stoull(expected.substr(with + 5)) : 1u);
  }
  if (const size_t open = expected.find("must open \""); open != std::string::npos) {
    const size_t first = open + 11;
    EXPECT_EQ(content.header.texture_files,
              std::vector<std::string>{expected.substr(first, expected.find('"', first) - first)});
  }
}

void expectRejected(const std::filesystem::path& path) {
  try {
    readPly(path);
    ADD_FAILURE() << "read without an Error";
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_NE(message.find(path.filename().string()), std::string::npos) << message;
  }
}

TEST(PlyManifest, everyFileIsReadOrRefusedAsItsRowSays) {
  const char* folder = std::getenv("LODESTREAM_TEST_DATA");
  if (folder == nullptr) GTEST_SKIP() << "set LODESTREAM_TEST_DATA to the folder with MANIFEST.tsv";
  size_t accepted = 0;
  size_t rejected = 0;
  for (auto& row : readManifest(folder)) {
    SCOPED_TRACE(row["file"]);
    const std::filesystem::path path = std::filesystem::path(folder) / row["file"];
    if (row["expected"].starts_with("accept")) {
      expectAccepted(path, row);
      ++accepted;
    } else if (row["expected"].starts_with("reject")) {
      expectRejected(path);
      ++rejected;
    }
  }
  EXPECT_GE(accepted, 25u);
  EXPECT_GE(rejected, 10u);
}

TEST(PlyManifest, theBigEndianFileEqualsItsAsciiTwin) {
  const char* folder = std::getenv("LODESTREAM_TEST_DATA");
  if (folder == nullptr) GTEST_SKIP() << "set LODESTREAM_TEST_DATA to the folder with MANIFEST.tsv";
  const PlyContent ascii = readPly(std::filesystem::path(folder) / "b_poscolor_ascii.ply");
  const PlyContent big = readPly(std::filesystem::path(folder) / "b_poscolor_be.ply");
  ASSERT_EQ(ascii.vertices.size(), big.vertices.size());
  for (size_t i = 0; i < ascii.vertices.size(); ++i) {
    // The ascii file has six digits.
    EXPECT_NEAR(glm::distance(ascii.vertices[i].position, big.vertices[i].position), 0, 1e-4);
    EXPECT_EQ(ascii.vertices[i].colour, big.vertices[i].colour);
  }
  EXPECT_EQ(ascii.faces, big.faces);
}

}  // namespace
}  // namespace lode::ingest
