// Tests of many consecutive faces without corners.

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kMany = 1'000'000;

std::string headOf(const std::string& format, uint64_t faces, const std::string& count_type) {
  return "ply\nformat " + format +
         " 1.0\nelement vertex 3\nproperty char x\nproperty char y\nproperty char z\n"
         "element face " +
         std::to_string(faces) + "\nproperty list " + count_type + " uchar vertex_indices\nend_header\n";
}

std::string vertices() { return {"\0\0\0\1\0\0\0\1\0", 9}; }

/// A row of a list with the given number of items 0, 1, 2, … @param count_bytes  size of the count.
std::string rowOf(uint8_t items, size_t count_bytes) {
  std::string row(count_bytes, '\0');
  row[0] = static_cast<char>(items);
  for (uint8_t i = 0; i < items; ++i) row.push_back(static_cast<char>(i));
  return row;
}

TEST(EmptyPlyFaces, areCountedAndTheFacesBetweenThemAreKept) {
  std::mt19937 random(1);
  const std::vector<std::pair<const char*, size_t>> count_types{{"uchar", 1}, {"ushort", 2}, {"int", 4}};
  for (const auto& [type, bytes] : count_types) {
    uint64_t empty = 0, faces = 0;
    std::string body;
    for (int run = 0; run < 60; ++run) {
      const uint64_t length = random() % 3 == 0 ? random() % 5000 : random() % 70;
      for (uint64_t i = 0; i < length; ++i) body += rowOf(0, bytes);
      empty += length;
      body += rowOf(3, bytes);
      ++faces;
    }
    const PlyContent content =
        readPlyBytes(headOf("binary_little_endian", empty + faces, type) + vertices() + body);
    EXPECT_EQ(content.faces, std::vector(faces, std::vector<uint64_t>{0, 1, 2})) << type;
    EXPECT_EQ(content.counts.faces, empty + faces) << type;
    EXPECT_EQ(content.counts.dropped_faces, empty) << type;
    EXPECT_EQ(content.counts.trailing_bytes, 0u) << type;
  }
}

TEST(EmptyPlyFaces, endWithTheirElement) {
  const PlyContent content = readPlyBytes(headOf("binary_little_endian", 1000, "uchar") + vertices() +
                                          rowOf(3, 1) + std::string(1999, '\0'));
  EXPECT_EQ(content.counts.dropped_faces, 999u);
  EXPECT_EQ(content.counts.trailing_bytes, 1000u);
}

TEST(EmptyPlyFaces, areSkippedWithTheirElement) {
  const std::string head =
      "ply\nformat binary_little_endian 1.0\nelement other 100000\nproperty list uchar float values\n"
      "element vertex 3\nproperty char x\nproperty char y\nproperty char z\n"
      "element face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
  const std::string others = std::string(77'777, '\0') + std::string("\1abcd", 5) + std::string(22'222, '\0');
  EXPECT_EQ(readPlyBytes(head + others + vertices() + rowOf(3, 1)).faces.size(), 1u);
}

TEST(EmptyPlyFaces, advanceTheProgress) {
  const PlyFolder folder;
  std::string lines;
  for (uint64_t i = 0; i < kMany; ++i) lines += "0\n";
  for (const bool is_ascii : {false, true}) {
    const std::string head = headOf(is_ascii ? "ascii" : "binary_little_endian", kMany + 1, "uchar");
    const std::string body = is_ascii ? "0 0 0\n1 0 0\n0 1 0\n" + lines + "3 0 1 2\n"
                                      : vertices() + std::string(kMany, '\0') + rowOf(3, 1);
    PlyReader reader(folder.write(head + body), {});
    std::vector<uint64_t> done;
    reader.read({}, {}, [&](uint64_t bytes, uint64_t) {
      if (done.empty() || bytes > done.back()) done.push_back(bytes);
    });
    EXPECT_GE(done.size(), is_ascii ? 10u : 3u);
  }
}

TEST(EmptyPlyFaces, areReportedWithThePlacesOfTheFirst) {
  std::vector<PlyDefect> defects;
  uint64_t rows = 0;
  PlyReadOptions options{.skip_bad = true};
  options.on_defect = [&](const PlyDefect& defect) {
    defects.push_back(defect);
    rows += defect.rows;
  };
  readPlyBytes(headOf("binary_little_endian", kMany + 1, "uchar") + vertices() + std::string(kMany, '\0') +
                   rowOf(3, 1),
               options);
  EXPECT_EQ(rows, kMany);
  ASSERT_GT(defects.size(), 2u);
  EXPECT_LT(defects.size(), 1000u) << "a run is one report";
  EXPECT_NE(defects[1].text.find("face 1 at byte"), std::string::npos) << defects[1].text;
}

}  // namespace
}  // namespace lode::ingest
