#include <random>

#include "tests/support/memory_file.h"
#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

std::string declaring(const std::string& format, const std::string& vertices, const std::string& faces) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

/// Reads hostile bytes and expects a mesh or an Error of one line.
bool isRead(const std::string& bytes, bool skip_bad) {
  const test::MemoryFile file(bytes);
  try {
    const PlyContent content = readPly(file.path(), {.skip_bad = skip_bad});
    for (const auto& face : content.faces) {
      EXPECT_GE(face.size(), 3u);
      for (const uint64_t corner : face) EXPECT_LT(corner, content.vertices.size());
    }
    return true;
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find_first_of("\r\n"), std::string::npos) << error.what();
    return false;
  }
}

TEST(PlyHostile, aHeaderThatDeclaresBillionsOverAFewBytesIsTruncation) {
  for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const auto& [vertices, faces] : std::vector<std::pair<std::string, std::string>>{
             {"4000000000", "1"}, {"3", "4000000000"}, {"18446744073709551615", "18446744073709551615"}}) {
      expectMentions(plyErrorOf(declaring(format, vertices, faces) + std::string(100, '0')), {"truncated"});
    }
  }
}

TEST(PlyHostile, aListThatDeclaresBillionsIsTruncation) {
  for (const std::string name : {"face", "tristrips", "other"}) {
    PlySource source = tetrahedron();
    source.elements.insert(source.elements.begin() + 1,
                           {name, {{"vertex_indices", "double", "uint"}}, {{{0, 1, 2}}}});
    if (name != "other") {
      source.elements[1].properties[0].type = "int";
      source.elements.pop_back();
    }
    std::string bytes = source.encode(PlyEncoding::kLittleEndian);
    const size_t count = bytes.find("end_header\n") + 11 + 4 * 12;
    bytes.replace(count, 4, "\xff\xff\xff\xff");
    expectMentions(plyErrorOf(bytes), {"truncated", name + " 0"});
  }
}

TEST(PlyHostile, negativeListCountsAreRefused) {
  PlySource source = tetrahedron();
  source.elements[1].properties[0].count_type = "char";
  std::string bytes = source.encode(PlyEncoding::kLittleEndian);
  bytes[bytes.find("end_header\n") + 11 + 4 * 12] = '\xff';
  expectMentions(plyErrorOf(bytes), {"face 0", "-1 items"});
}

TEST(PlyHostile, everyTruncationOfABinaryFileIsAnError) {
  for (const PlyEncoding encoding : {PlyEncoding::kLittleEndian, PlyEncoding::kBigEndian}) {
    const std::string bytes = everything().encode(encoding);
    for (size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(isRead(bytes.substr(0, size), size % 2 == 0)) << size;
    }
    EXPECT_TRUE(isRead(bytes, false));
  }
}

TEST(PlyHostile, everyTruncationOfAnAsciiFileIsAnErrorUntilTheLastNumber) {
  const std::string bytes = everything().encode(PlyEncoding::kAscii);
  for (size_t size = 0; size + 2 < bytes.size(); ++size) {
    EXPECT_FALSE(isRead(bytes.substr(0, size), size % 2 == 0)) << size;
  }
  EXPECT_TRUE(isRead(bytes.substr(0, bytes.size() - 1), false)) << "only the last line end is missing";
}

TEST(PlyHostile, randomChangesGiveAMeshOrAnError) {
  std::mt19937 random(7);
  for (const PlyEncoding encoding : kPlyEncodings) {
    for (int i = 0; i < 3000; ++i) {
      PlySource source = everything();
      if (i % 2 == 0) std::swap(source.elements[0], source.elements[2]);
      std::string bytes = source.encode(encoding);
      const size_t body = bytes.find("end_header");
      for (auto changes = random() % 8 + 1; changes > 0; --changes) {
        const size_t at = i % 3 == 0 ? random() % body : body + random() % (bytes.size() - body);
        if (random() % 2 == 0) {
          bytes[at] = static_cast<char>(random());
        } else {
          bytes[at] = "0123456789 -+.eE\n\r\t"[random() % 19];
        }
        if (random() % 8 == 0) bytes.erase(at, random() % 9);
        if (random() % 8 == 0) bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 40));
      }
      isRead(bytes, i % 5 == 0);
    }
  }
}

TEST(PlyHostile, binaryGarbageGivesAMeshOrAnError) {
  std::mt19937 random(11);
  for (int i = 0; i < 1000; ++i) {
    std::string garbage;
    for (auto n = random() % 300; n > 0; --n) garbage += static_cast<char>(random() % (i % 2 ? 256 : 6));
    isRead(garbage, false);
    isRead(declaring(i % 3 ? "binary_little_endian" : "ascii", "3", "5") + garbage, i % 2 == 0);
  }
}

TEST(PlyHostile, joinedOrWrappedRowsAreErrorsThatNameTheExpectedRow) {
  const std::string text = tetrahedron().encode(PlyEncoding::kAscii);
  const size_t body = text.find("end_header\n") + 11;
  std::string joined = text, wrapped = text;
  std::replace(joined.begin() + static_cast<ptrdiff_t>(body), joined.end(), '\n', ' ');
  std::replace(wrapped.begin() + static_cast<ptrdiff_t>(body), wrapped.end(), ' ', '\n');
  expectMentions(plyErrorOf(joined), {"vertex 1", "with one row per line"});
  expectMentions(plyErrorOf(wrapped), {"vertex 0", "with one row per line"});
}

}  // namespace
}  // namespace lode::ingest
