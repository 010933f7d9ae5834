#include "server/ingest/ply/ply_header.h"

#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

const std::vector<std::string> kHeader = {"ply",
                                          "format binary_little_endian 1.0",
                                          "comment a  b",
                                          "element vertex 3",
                                          "property float x",
                                          "property float y",
                                          "property float z",
                                          "element face 1",
                                          "property list uchar int vertex_indices",
                                          "end_header"};

std::string headerWith(const std::string& line_end, const std::string& last_end) {
  std::string text;
  for (const std::string& line : kHeader) text += line + (line == "end_header" ? last_end : line_end);
  return text;
}

PlyHeader headerOf(const std::string& bytes) {
  const PlyFolder folder;
  return readPlyHeader(folder.write(bytes));
}

std::string headerError(const std::string& header) { return plyErrorOf(header); }

TEST(PlyHeader, readsElementsPropertiesAndComments) {
  const PlyHeader header = headerOf(headerWith("\n", "\n"));
  EXPECT_EQ(header.encoding, PlyEncoding::kLittleEndian);
  ASSERT_EQ(header.elements.size(), 2u);
  EXPECT_EQ(header.elements[0].count, 3u);
  EXPECT_EQ(header.elements[0].properties.size(), 3u);
  EXPECT_TRUE(header.elements[1].properties[0].is_list);
  EXPECT_EQ(header.comments, std::vector<std::string>{"a  b"});
  EXPECT_EQ(header.header_lines, kHeader.size());
}

TEST(PlyHeader, findsTheBodyBehindAnyLineEnd) {
  for (const std::string end : {"\n", "\r", "\r\n"}) {
    const std::string text = headerWith(end, end);
    EXPECT_EQ(headerOf(text + std::string(50, '\0')).body_offset, text.size());
  }
}

TEST(PlyHeader, readsALineFeedAfterACarriageReturnHeaderAsBody) {
  const std::string text = headerWith("\r", "\r");
  EXPECT_EQ(headerOf(text + "\n" + std::string(50, '\0')).body_offset, text.size());
}

TEST(PlyHeader, readsCarriageReturnLineFeedAfterALineFeedHeaderAsOneEnd) {
  const std::string text = headerWith("\n", "\r\n");
  EXPECT_EQ(headerOf(text + std::string(50, '\0')).body_offset, text.size());
}

TEST(PlyHeader, leavesALineFeedThatBeginsTheBody) {
  const std::string text = headerWith("\n", "\n");
  EXPECT_EQ(headerOf(text + "\n" + std::string(50, '\0')).body_offset, text.size());
}

TEST(PlyHeader, knowsEveryTypeByBothNames) {
  const std::vector<std::pair<std::string, PlyType>> types = {
      {"char", PlyType::kInt8},      {"int8", PlyType::kInt8},       {"uchar", PlyType::kUint8},
      {"uint8", PlyType::kUint8},    {"short", PlyType::kInt16},     {"int16", PlyType::kInt16},
      {"ushort", PlyType::kUint16},  {"uint16", PlyType::kUint16},   {"int", PlyType::kInt32},
      {"int32", PlyType::kInt32},    {"uint", PlyType::kUint32},     {"uint32", PlyType::kUint32},
      {"float", PlyType::kFloat32},  {"float32", PlyType::kFloat32}, {"double", PlyType::kFloat64},
      {"float64", PlyType::kFloat64}};
  for (const auto& [name, type] : types) {
    const PlyHeader header =
        headerOf("ply\nformat ascii 1.0\nelement vertex 1\nproperty " + name + " x\nend_header\n1\n");
    EXPECT_EQ(header.elements[0].properties[0].type, type) << name;
  }
}

TEST(PlyHeader, keepsTheBlanksInsideATextureName) {
  const PlyHeader header = headerOf(
      "ply\nformat ascii 1.0\ncomment TextureFile   my own  map.jpg \ncomment TextureFile "
      "b.png\nend_header\n");
  EXPECT_EQ(header.texture_files, (std::vector<std::string>{"my own  map.jpg", "b.png"}));
}

TEST(PlyHeader, expandsThisInATextureNameToTheFileName) {
  const PlyFolder folder;
  const std::filesystem::path path =
      folder.write("ply\nformat ascii 1.0\ncomment TextureFile <this>_0.png\nend_header\n");
  EXPECT_EQ(readPlyHeader(path).texture_files, (std::vector<std::string>{path.stem().string() + "_0.png"}));
}

TEST(PlyHeader, namesTheErrorAndItsPlace) {
  const std::string start = "ply\nformat ascii 1.0\n";
  expectMentions(headerError(""), {"is empty"});
  expectMentions(headerError("solid cube\n"), {"not a PLY file", "'solid cube\\x0a'"});
  expectMentions(headerError("\xef\xbb\xbfply\n"), {"byte-order mark", "without one"});
  expectMentions(headerError("version https://git-lfs.github.com/spec/v1\noid sha256:0\n"), {"git lfs pull"});
  expectMentions(headerError("\x1f\x8b\x08"), {"compressed with gzip", "/mesh.ply > ", "/mesh.unpacked.ply"});
  expectMentions(headerError("BZh91AY&SY"), {"compressed with bzip2", "bzip2 -dc "});
  expectMentions(headerError(std::string("\xfd\x37zXZ\0", 6)), {"compressed with xz", "xz -dc "});
  expectMentions(headerError("\x28\xb5\x2f\xfd\x04"), {"compressed with zstd", "zstd -dc "});
  expectMentions(headerError(std::string("glTF\2\0\0\0", 8)),
                 {"GLB", "Lodestream reads PLY", "mesh.converted.ply`"});
  expectMentions(headerError("\xff\xd8\xff\xe0"), {"a JPEG picture", "name the PLY file"});
  expectMentions(headerError("ply\nformat ascii 2.0\nend_header\n"), {"line 2", "version '2.0'"});
  expectMentions(headerError("ply\nformat binary 1.0\nend_header\n"), {"line 2", "'binary'"});
  expectMentions(headerError("ply\nelement vertex 1\nproperty float x\nend_header\n"), {"'format'"});
  expectMentions(headerError(start + "format ascii 1.0\nend_header\n"), {"line 3", "second 'format'"});
  expectMentions(headerError(start + "<<<<<<< HEAD\nend_header\n"), {"line 3", "'<<<<<<< HEAD'"});
  expectMentions(headerError(start + "element vertex -3\nend_header\n"), {"line 3", "'-3'"});
  expectMentions(headerError(start + "element vertex 99999999999999999999\nend_header\n"), {"line 3"});
  expectMentions(headerError(start + "element vertex 1\nproperty vec3 x\nend_header\n"),
                 {"line 4", "'vec3'"});
  expectMentions(headerError(start + "element vertex 1\nproperty float\nend_header\n"), {"line 4", "name"});
  expectMentions(headerError(start + "property float x\nend_header\n"), {"line 3", "before any element"});
  expectMentions(headerError(start + "element face 1\nproperty list float int vertex_indices\nend_header\n"),
                 {"line 4", "floating"});
  expectMentions(headerError(start + "element vertex 1\nend_header\n"), {"'vertex'", "no properties"});
  expectMentions(
      headerError(start + "element a 1\nproperty int i\nelement a 1\nproperty int i\nend_header\n"),
      {"line 5", "second element 'a'"});
  expectMentions(headerError(start + "element vertex 1\nproperty float x\n"), {"without end_header"});
}

TEST(PlyHeader, refusesAHeaderWithoutEnd) {
  expectMentions(headerError("ply\nformat ascii 1.0\n" + std::string(2 * kMaxPlyHeaderBytes, '\n')),
                 {"no end_header within"});
}

TEST(PlyHeader, reportsItsLimitForATooLongHeader) {
  const std::string lines[] = {"comment a long comment", "element vertex 1", "property float x", "end_header",
                               "obj_info a tex\r"};
  const std::string start = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float y\n";
  for (const std::string& line : lines)
    for (size_t inside = 0; inside <= line.size(); inside += 5) {
      std::string text = start + "comment ";
      text += std::string(kMaxPlyHeaderBytes - text.size() - 1 - inside, 'x') + "\n" + line;
      expectMentions(headerError(text + "\nend_header\n1\n"),
                     {"no end_header within 1048576 bytes, the limit of a header", "shorten its comments"});
    }
}

TEST(PlyHeader, readsAHeaderAsLongAsTheLimit) {
  const std::string end = "\nelement vertex 1\nproperty float x\nend_header\n";
  std::string text = "ply\nformat ascii 1.0\ncomment ";
  text += std::string(kMaxPlyHeaderBytes - text.size() - end.size(), 'x') + end;
  EXPECT_EQ(headerOf(text + "1\n").body_offset, kMaxPlyHeaderBytes);
}

TEST(PlyHeader, refusesMoreElementsThanTheLimit) {
  std::string text = "ply\nformat ascii 1.0\n";
  for (size_t i = 0; i <= kMaxPlyElements; ++i) text += "element e" + std::to_string(i) + " 0\n";
  expectMentions(headerError(text + "end_header\n"), {"more than 256 elements"});
}

TEST(PlyHeader, refusesMorePropertiesThanTheLimit) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex 0\n";
  for (size_t i = 0; i <= kMaxPlyProperties; ++i) text += "property float p" + std::to_string(i) + "\n";
  expectMentions(headerError(text + "end_header\n"), {"more than 4096 properties"});
}

TEST(PlyHeader, refusesAPathThatIsNoFile) {
  const PlyFolder folder;
  const auto codeOf = [](const std::filesystem::path& path) {
    try {
      readPlyHeader(path);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::kInternal;
  };
  EXPECT_EQ(codeOf(folder.path()), ErrorCode::kIo);
  EXPECT_EQ(codeOf(folder.path() / "missing.ply"), ErrorCode::kIo);
  EXPECT_EQ(codeOf("/dev/zero"), ErrorCode::kIo);
}

}  // namespace
}  // namespace lode::ingest
