#include "server/ingest/ply/ply_reader.h"

#include <limits>

#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

std::string asciiMesh(
    const std::string& vertex_rows, const std::string& face_rows, int vertices = 4, int faces = 1,
    const std::string& vertex_properties = "property float x\nproperty float y\nproperty float z\n",
    const std::string& face_properties = "property list uchar int vertex_indices\n") {
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(vertices) + "\n" + vertex_properties +
         "element face " + std::to_string(faces) + "\n" + face_properties + "end_header\n" + vertex_rows +
         face_rows;
}

const std::string kSquare = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";  // lines 10 to 13 of asciiMesh
using Faces = std::vector<std::vector<uint64_t>>;

TEST(PlyReader, readsTheSameFromEveryEncoding) {
  const PlyContent ascii = readPlyBytes(everything().encode(PlyEncoding::kAscii));
  EXPECT_EQ(ascii.attributes.bits, AttributeSet::kAll);
  EXPECT_EQ(ascii.vertices[0].position, glm::dvec3(0.1, 0, 0));
  EXPECT_EQ(ascii.vertices[1].position, glm::dvec3(1, 1e6, 0));
  EXPECT_EQ(ascii.vertices[1].normal, glm::vec3(0, 1, 0));
  EXPECT_EQ(ascii.vertices[0].texture, glm::vec2(0.25, 0.75));
  EXPECT_EQ(ascii.faces, (Faces{{0, 1, 2}, {0, 1, 2, 3}, {1, 2, 3}, {0, 1, 2}, {2, 1, 3}, {3, 2, 1}}));
  EXPECT_EQ(ascii.materials, (std::vector<uint16_t>{3, kNoMaterial, 0, 0, 0, 0}));
  ASSERT_EQ(ascii.texture.size(), 19u);
  EXPECT_EQ(ascii.texture[6], glm::vec2(0.5, 0.5));
  EXPECT_EQ(ascii.counts.faces, 5u);
  for (const PlyEncoding encoding : {PlyEncoding::kLittleEndian, PlyEncoding::kBigEndian}) {
    const PlyContent binary = readPlyBytes(everything().encode(encoding));
    EXPECT_EQ(binary.attributes, ascii.attributes);
    EXPECT_EQ(binary.faces, ascii.faces);
    EXPECT_EQ(binary.texture, ascii.texture);
    EXPECT_EQ(binary.materials, ascii.materials);
    ASSERT_EQ(binary.vertices.size(), ascii.vertices.size());
    for (size_t i = 0; i < ascii.vertices.size(); ++i) {
      EXPECT_EQ(binary.vertices[i].position, ascii.vertices[i].position);
      EXPECT_EQ(binary.vertices[i].normal, ascii.vertices[i].normal);
      EXPECT_EQ(binary.vertices[i].colour, ascii.vertices[i].colour);
      EXPECT_EQ(binary.vertices[i].texture, ascii.vertices[i].texture);
    }
  }
}

TEST(PlyReader, scalesColoursByTheirType) {
  const PlyContent content = readPlyBytes(everything().encode(PlyEncoding::kLittleEndian));
  EXPECT_EQ(content.vertices[0].colour, glm::u8vec4(255, 128, 1, 255));
  EXPECT_EQ(content.vertices[1].colour, glm::u8vec4(1, 255, 2, 255));
  EXPECT_EQ(content.vertices[2].colour, glm::u8vec4(0, 0, 3, 0));
  EXPECT_EQ(content.vertices[3].colour, glm::u8vec4(0, 26, 4, 7));
}

TEST(PlyReader, readsElementsInAnyOrder) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = everything();
    const PlyContent forward = readPlyBytes(source.encode(encoding));
    std::swap(source.elements[0], source.elements[2]);  // face, camera, vertex, tristrips
    const PlyContent swapped = readPlyBytes(source.encode(encoding));
    EXPECT_EQ(swapped.faces, forward.faces);
    EXPECT_EQ(swapped.vertices.size(), forward.vertices.size());
    std::swap(source.elements[1], source.elements[3]);  // face, tristrips, vertex, camera
    std::swap(source.elements[2], source.elements[3]);
    EXPECT_EQ(readPlyBytes(source.encode(encoding)).faces, forward.faces);
  }
}

TEST(PlyReader, readsRowsOfVerticesThatHoldLists) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = tetrahedron();
    source.elements[0].properties.insert(source.elements[0].properties.begin() + 1,
                                         {"bones", "short", "uchar"});
    for (size_t i = 0; i < 4; ++i) {
      source.elements[0].rows[i].insert(source.elements[0].rows[i].begin() + 1, std::vector<double>(i, 5));
    }
    const PlyContent content = readPlyBytes(source.encode(encoding));
    EXPECT_EQ(content.vertices[3].position, glm::dvec3(0, 0, 1));
    EXPECT_EQ(content.counts.triangles, 4u);
  }
}

TEST(PlyReader, acceptsEveryIntegerTypeForCountsAndIndices) {
  for (const std::string type : {"char", "uchar", "short", "ushort", "int", "uint"}) {
    for (const std::string count_type : {"char", "uchar", "short", "ushort", "int", "uint"}) {
      for (const PlyEncoding encoding : kPlyEncodings) {
        PlySource source = tetrahedron();
        source.elements[1].properties[0] = {"vertex_index", type, count_type};
        EXPECT_EQ(readPlyBytes(source.encode(encoding)).faces,
                  (Faces{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}));
      }
    }
  }
}

TEST(PlyReader, acceptsEveryTypeForCoordinates) {
  for (const std::string type : {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"}) {
    for (const PlyEncoding encoding : kPlyEncodings) {
      PlySource source = tetrahedron();
      for (auto& property : source.elements[0].properties) property.type = type;
      EXPECT_EQ(readPlyBytes(source.encode(encoding)).vertices[2].position, glm::dvec3(0, 1, 0));
    }
  }
}

TEST(PlyReader, readsFilesLargerThanItsBuffersInOrder) {
  PlySource source = tetrahedron();
  source.elements[0].rows.clear();
  source.elements[1].rows.clear();
  for (int i = 0; i < 300'000; ++i) {
    source.elements[0].rows.push_back({{double(i)}, {double(i % 7)}, {0}});
    if (i >= 4)
      source.elements[1].rows.push_back(
          {i % 3 ? std::vector<double>{double(i), double(i - 1), double(i - 2)}
                 : std::vector<double>{double(i - 3), double(i - 2), double(i - 1), double(i)}});
  }
  for (const PlyEncoding encoding : kPlyEncodings) {
    const PlyContent content = readPlyBytes(source.encode(encoding));
    ASSERT_EQ(content.vertices.size(), 300'000u);
    for (size_t i = 0; i < 300'000; ++i) ASSERT_EQ(content.vertices[i].position.x, double(i));
    ASSERT_EQ(content.faces.size(), 299'996u);
    for (size_t i = 4; i < 300'000; ++i) ASSERT_EQ(content.faces[i - 4].front(), i % 3 ? i : i - 3);
  }
}

TEST(PlyReader, reportsProgressThatRisesToTheEnd) {
  PlySource source = tetrahedron();
  std::swap(source.elements[0], source.elements[1]);
  const PlyFolder folder;
  PlyReader reader(folder.write(source.encode(PlyEncoding::kBigEndian)), {});
  uint64_t last = 0;
  uint64_t total = 0;
  reader.read({}, {}, [&](uint64_t done, uint64_t all) {
    EXPECT_GE(done, last);
    EXPECT_LE(done, all);
    last = done;
    total = all;
  });
  EXPECT_EQ(last, total);
  EXPECT_EQ(total, 4u * 12 + 4u * 13);
}

TEST(PlyReader, readsAgainFromTheStart) {
  const PlyFolder folder;
  PlyReader reader(folder.write(everything().encode(PlyEncoding::kAscii)), {});
  EXPECT_EQ(reader.read({}, {}).triangles, reader.read({}, {}).triangles);
}

TEST(PlyReader, takesAnyLineEndInAsciiBodies) {
  const std::string unix_text = asciiMesh(kSquare, "4 0 1 2 3\n");
  for (const std::string end : {"\r", "\r\n", "\n\n", " \t\n"}) {
    std::string text;
    for (const char c : unix_text) text += c == '\n' ? end : std::string(1, c);
    EXPECT_EQ(readPlyBytes(text).faces, (Faces{{0, 1, 2, 3}}));
  }
  EXPECT_EQ(readPlyBytes(asciiMesh(kSquare, "4 0 1 2 3")).faces.size(), 1u);
}

TEST(PlyReader, readsNumbersInAllTheirSpellings) {
  const PlyContent content =
      readPlyBytes(asciiMesh("+1.5 -2e3 .5\n1. 1E-2 -0\n16777217 0.1 1e-50\n0 0 0\n", "+3.0 0 1.0 2e0\n"));
  EXPECT_EQ(content.vertices[0].position, glm::dvec3(1.5, -2000, 0.5));
  EXPECT_EQ(content.vertices[1].position, glm::dvec3(1, double(0.01f), 0));
  EXPECT_EQ(content.vertices[2].position, glm::dvec3(16777216, double(0.1f), 0))
      << "rounded as the type float says";
  EXPECT_EQ(content.faces, (Faces{{0, 1, 2}}));
}

TEST(PlyReader, ignoresAndCountsExtraTokens) {
  const PlyContent content = readPlyBytes(asciiMesh("0 0 0 9 9\n1 0 0\n1 1 0\n0 1 0\n", "3 0 1 2 7\n"));
  EXPECT_EQ(content.counts.extra_tokens, 3u);
  EXPECT_EQ(content.faces, (Faces{{0, 1, 2}}));
}

TEST(PlyReader, countsBytesBehindTheLastElement) {
  EXPECT_EQ(readPlyBytes(tetrahedron().encode(PlyEncoding::kLittleEndian) + "12345").counts.trailing_bytes,
            5u);
  EXPECT_EQ(readPlyBytes(asciiMesh(kSquare, "3 0 1 2\n \r\n\n1 2")).counts.trailing_bytes, 3u);
}

TEST(PlyReader, refusesAShortRowWithItsLine) {
  expectMentions(plyErrorOf(asciiMesh("0 0 0\n1 0\n1 1 0\n0 1 0\n", "3 0 1 2\n")),
                 {"vertex 1", "line 11", "too short", "z"});
  expectMentions(plyErrorOf(asciiMesh(kSquare, "4 0 1 2\n")), {"face 0", "line 14", "too short"});
}

TEST(PlyReader, refusesWordsThatAreNoNumbers) {
  expectMentions(plyErrorOf(asciiMesh("0 0 0\n1 0,5 0\n1 1 0\n0 1 0\n", "3 0 1 2\n")),
                 {"vertex 1", "line 11", "'0,5'", "not a number"});
  expectMentions(plyErrorOf(asciiMesh(kSquare, "3 0 1 x\n")), {"face 0", "line 14", "'x'"});
  expectMentions(plyErrorOf(asciiMesh(kSquare, "3 0 1 1.5\n")), {"'1.5'", "whole number"});
  expectMentions(
      plyErrorOf(asciiMesh("0 0 " + std::string(1000, '1') + "\n1 0 0\n1 1 0\n0 1 0\n", "3 0 1 2\n")),
      {"vertex 0", "line 10", "more than 512 characters"});
}

TEST(PlyReader, refusesIntegersOutOfTheRangeOfTheirType) {
  const std::string coloured =
      "property float x\nproperty float y\nproperty float z\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\n";
  const auto mesh = [&](const std::string& red) {
    return asciiMesh("0 0 0 1 2 3\n1 0 0 " + red + " 2 3\n0 1 0 1 2 3\n", "3 0 1 2\n", 3, 1, coloured);
  };
  EXPECT_EQ(readPlyBytes(mesh("255")).vertices[1].colour.r, 255);
  expectMentions(plyErrorOf(mesh("256")), {"vertex 1", "line 14", "'256'", "range of uchar"});
  expectMentions(plyErrorOf(mesh("-1")), {"'-1'", "range of uchar"});
  expectMentions(plyErrorOf(mesh("99999999999999999999")), {"range of uchar"});
  expectMentions(plyErrorOf(asciiMesh(kSquare, "300 0 1 2\n")), {"face 0", "'300'", "range of uchar"});
}

TEST(PlyReader, dropsAndCountsFacesOfFewerThanThreeCornersOrWithRepeatedOnes) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = tetrahedron();
    source.elements[1].rows = {{{}},        {{1}},          {{1, 2}},       {{0, 1, 0}},
                               {{0, 1, 2}}, {{0, 1, 2, 1}}, {{3, 2, 1, 0}}, {{0, 0, 1}}};
    const PlyContent content = readPlyBytes(source.encode(encoding));
    EXPECT_EQ(content.faces, (Faces{{0, 1, 2}, {3, 2, 1, 0}}));
    EXPECT_EQ(content.counts.faces, 8u);
    EXPECT_EQ(content.counts.dropped_faces, 6u);
    EXPECT_EQ(content.counts.dropped_triangles, 4u) << "two of the quad, none of fewer than three corners";
    EXPECT_EQ(content.counts.triangles, 3u);
    EXPECT_EQ(content.counts.skipped_bad, 0u);
  }
}

TEST(PlyReader, refusesMeshesWithoutVerticesOrFaces) {
  PlySource source = tetrahedron();
  source.elements[1].rows.clear();
  expectMentions(plyErrorOf(source.encode(PlyEncoding::kAscii)), {"no faces"});
  source.elements.pop_back();
  expectMentions(plyErrorOf(source.encode(PlyEncoding::kAscii)), {"no faces"});
  source.elements[0].rows.clear();
  expectMentions(plyErrorOf(source.encode(PlyEncoding::kAscii)), {"no vertices"});
}

TEST(PlyReader, refusesElementsWithoutRequiredProperties) {
  PlySource source = tetrahedron();
  source.elements[0].properties[2].name = "height";
  expectMentions(plyErrorOf(source.encode(PlyEncoding::kAscii)), {"has no x, y or z"});
  source = tetrahedron();
  source.elements[1].properties[0].name = "edges";
  expectMentions(plyErrorOf(source.encode(PlyEncoding::kAscii)), {"no list vertex_indices"});
  source = tetrahedron();
  source.elements[1].properties[0].type = "float";
  expectMentions(plyErrorOf(source.encode(PlyEncoding::kAscii)), {"floating"});
}

TEST(PlyReader, recognizesAGaussianSplat) {
  const std::string floats = "property float ", position = floats + "x\n" + floats + "y\n" + floats + "z\n";
  const auto properties = [&](const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += floats + name + "\n";
    return text;
  };
  const std::string rotation = properties({"rot_0", "rot_1", "rot_2", "rot_3"});
  const std::string splats[] = {
      position +
          properties({"nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "f_rest_0", "opacity", "scale_0",
                      "scale_1", "scale_2"}) +
          rotation,
      position + properties({"f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1"}) + rotation,
      rotation + properties({"scale_0", "scale_1", "scale_2", "opacity", "red", "green", "blue"}) + position,
      "property uint packed_position\nproperty uint packed_rotation\nproperty uint packed_scale\n"
      "property uint packed_color\n"};
  for (const std::string& splat : splats)
    for (const std::string face : {"", "element face 0\nproperty list uchar int vertex_indices\n"})
      expectMentions(plyErrorOf("ply\nformat ascii 1.0\nelement vertex 1\n" + splat + face + "end_header\n" +
                                std::string(40, '1') + "\n"),
                     {"is a Gaussian splat, not a mesh", "reconstruct a surface"});
}

TEST(PlyReader, readsAMeshWhoseVerticesAlsoHaveSplatProperties) {
  const std::string bytes =
      asciiMesh("0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n1 1 0 1 1 1 1\n0 1 0 1 1 1 1\n", "3 0 1 2\n", 4, 1,
                "property float x\nproperty float y\nproperty float z\nproperty float opacity\n"
                "property float scale_0\nproperty float rot_0\nproperty float rot_3\n");
  EXPECT_EQ(readPlyBytes(bytes).faces, (Faces{{0, 1, 2}}));
}

TEST(PlyReader, refusesIndicesOutOfRangeWithTheirPlace) {
  for (const double index : {4.0, -1.0, 1e9}) {
    PlySource source = tetrahedron();
    source.elements[1].rows[2] = {{0, 1, index}};
    const std::string number = std::to_string(static_cast<int64_t>(index));
    expectMentions(plyErrorOf(source.encode(PlyEncoding::kAscii)), {"face 2 at line 16", "vertex " + number});
    const std::string binary = source.encode(PlyEncoding::kLittleEndian);
    expectMentions(plyErrorOf(binary), {"face 2 at byte " + std::to_string(binary.size() - 26),
                                        "vertex " + number, "--skip-bad"});
  }
}

TEST(PlyReader, skipsAndCountsFacesWithIndicesOutOfRangeIfAsked) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = tetrahedron();
    source.elements[1].rows[2] = {{0, 1, 4}};
    source.elements[1].rows[3] = {{0, 1, -7, 2}};
    const PlyContent content = readPlyBytes(source.encode(encoding), {.skip_bad = true});
    EXPECT_EQ(content.faces, (Faces{{0, 2, 1}, {0, 1, 3}}));
    EXPECT_EQ(content.counts.skipped_bad, 2u);
    EXPECT_EQ(content.counts.dropped_faces, 0u);
    EXPECT_EQ(content.counts.dropped_triangles, 3u);
  }
}

TEST(PlyReader, refusesPositionsThatAreNotFiniteWithTheirPlace) {
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity()}) {
    PlySource source = tetrahedron();
    source.elements[0].rows[1][2] = {value};
    expectMentions(plyErrorOf(source.encode(PlyEncoding::kAscii)),
                   {"vertex 1 at line 11", "NaN or infinite"});
    const std::string binary = source.encode(PlyEncoding::kBigEndian);
    expectMentions(plyErrorOf(binary), {"vertex 1 at byte " + std::to_string(binary.size() - 4 * 13 - 3 * 12),
                                        "NaN or infinite"});
  }
  expectMentions(plyErrorOf(asciiMesh("0 0 0\n1 0 0\n1 -1.#IND 0\n0 1 0\n", "3 0 1 2\n")),
                 {"vertex 2", "NaN"});
  expectMentions(plyErrorOf(asciiMesh("0 0 0\n1 0 0\n1 1e300 0\n0 1 0\n", "3 0 1 2\n")),
                 {"vertex 2", "infinite"});
}

TEST(PlyReader, skipsVerticesThatAreNotFiniteAndTheirFacesIfAsked) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = tetrahedron();
    source.elements[0].rows[3][0] = {std::numeric_limits<double>::quiet_NaN()};
    const PlyContent content = readPlyBytes(source.encode(encoding), {.skip_bad = true});
    ASSERT_EQ(content.vertices.size(), 4u) << "numbers must stay";
    EXPECT_EQ(content.vertices[3].position, glm::dvec3(0));
    EXPECT_EQ(content.faces, (Faces{{0, 2, 1}}));
    EXPECT_EQ(content.counts.skipped_bad, 4u);
    EXPECT_EQ(content.counts.dropped_triangles, 3u) << "of faces, not of vertices";
  }
}

TEST(PlyReader, keepsVerticesWhoseAttributesAreNotFiniteIfAsked) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = everything();
    source.elements[0].rows[1][5] = {std::numeric_limits<double>::quiet_NaN()};  // ny
    source.elements[0].rows[2][8] = {std::numeric_limits<double>::infinity()};   // green
    expectMentions(plyErrorOf(source.encode(encoding)), {"vertex 1", "attribute"});
    const PlyContent content = readPlyBytes(source.encode(encoding), {.skip_bad = true});
    EXPECT_EQ(content.vertices[1].normal, glm::vec3(0));
    EXPECT_EQ(content.vertices[1].position, glm::dvec3(1, 1e6, 0));
    EXPECT_EQ(content.counts.replaced_attributes, 2u);
    EXPECT_EQ(content.counts.skipped_bad, 0u);
    EXPECT_EQ(content.counts.dropped_triangles, 0u);
    EXPECT_EQ(content.faces.size(), 6u);
  }
}

TEST(PlyReader, refusesTextureCoordinatesThatDoNotMatchTheCorners) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = everything();
    source.elements[2].rows[1][3].pop_back();
    expectMentions(plyErrorOf(source.encode(encoding)), {"face 1", "7 texture coordinates for 4 corners"});
    const PlyContent content = readPlyBytes(source.encode(encoding), {.skip_bad = true});
    EXPECT_EQ(content.faces.size(), 5u);
    EXPECT_EQ(content.counts.dropped_triangles, 2u);
    source = everything();
    source.elements[2].rows[0][3][2] = std::numeric_limits<double>::quiet_NaN();
    expectMentions(plyErrorOf(source.encode(encoding)), {"face 0", "NaN"});
  }
}

TEST(PlyReader, cutsStripsWithAlternatingWindingAndRestarts) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = tetrahedron();
    source.elements[1] = {"tristrips",
                          {{"vertex_indices", "int", "int"}},
                          {{{0, 1, 2, 3, 0, -1, -1, 3, 2, 2, 1, -1, 0, 1}}, {{1, 2, 3}}}};
    const PlyContent content = readPlyBytes(source.encode(encoding));
    EXPECT_EQ(content.faces, (Faces{{0, 1, 2}, {2, 1, 3}, {2, 3, 0}, {1, 2, 3}}));
    EXPECT_EQ(content.counts.faces, 4u) << "strips";
    EXPECT_EQ(content.counts.dropped_faces, 2u) << "the two that repeat 2";
    source.elements[1].rows[1] = {{1, 2, 4}};
    expectMentions(plyErrorOf(source.encode(encoding)), {"tristrips 1", "no vertex 4"});
    EXPECT_EQ(readPlyBytes(source.encode(encoding), {.skip_bad = true}).counts.skipped_bad, 1u);
  }
}

TEST(PlyReader, streamsStripsLongerThanAnyBuffer) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = tetrahedron();
    std::vector<double> strip;
    for (int i = 0; i < 1'500'000; ++i) strip.push_back(i % 4);
    source.elements[1] = {"tristrips", {{"vertex_indices", "int", "int"}}, {{strip}}};
    const PlyFolder folder;
    PlyReader reader(folder.write(source.encode(encoding)), {});
    EXPECT_EQ(reader.read({}, {}).triangles, 1'499'998u);
  }
}

TEST(PlyReader, refusesFacesOfMoreCornersThanTheLimit) {
  for (const PlyEncoding encoding : kPlyEncodings) {
    PlySource source = tetrahedron();
    source.elements[1].properties[0].count_type = "uint";
    source.elements[1].rows = {{std::vector<double>((1 << 16) + 1, 0)}};
    expectMentions(plyErrorOf(source.encode(encoding)), {"face 0", "65537 items"});
  }
}

TEST(PlyReader, namesEveryPropertyThatItDoesNotRead) {
  const PlyFolder folder;
  const auto skippedOf = [&](const std::string& header) {
    return PlyReader(folder.write("ply\nformat ascii 1.0\n" + header + "end_header\n"), {})
        .skippedProperties();
  };
  const std::string positions = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
  EXPECT_EQ(skippedOf(positions + faces), std::vector<std::string>{});
  EXPECT_EQ(skippedOf(positions + "property float confidence\n" + faces +
                      "property list uchar float texcoord\nproperty uchar flags\n"),
            (std::vector<std::string>{"vertex 'confidence'", "face 'flags'"}));
  EXPECT_EQ(skippedOf(positions + "property uchar color_0\nproperty uchar color_1\nproperty uchar color_2\n" +
                      faces + "element multi_texture_vertex 2\nproperty uchar tx\nproperty float u\n"),
            (std::vector<std::string>{"vertex 'color_0'", "vertex 'color_1'", "vertex 'color_2'",
                                      "all of 'multi_texture_vertex'"}));
  EXPECT_EQ(skippedOf(positions + faces + "element edge 0\nproperty int a\n"), std::vector<std::string>{})
      << "there is nothing to lose";
}

TEST(PlyReader, namesVertexCoordinatesThatCornerCoordinatesReplace) {
  const PlyFolder folder;
  const PlyReader reader(
      folder.write(
          "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
          "property float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\n"
          "property list uchar float texcoord\nend_header\n"),
      {});
  EXPECT_EQ(reader.skippedProperties(), (std::vector<std::string>{"vertex 's'", "vertex 't'"}));
}

TEST(PlyReader, namesTheFirstSkippedPropertiesAndCountsTheRest) {
  EXPECT_EQ(skippedInWords({}), "");
  EXPECT_EQ(skippedInWords({"a 'b'", "c 'd'"}), "ignored properties: a 'b', c 'd'");
  const std::string many = skippedInWords(std::vector<std::string>(100, "a 'b'"));
  EXPECT_LT(many.size(), 200u);
  EXPECT_NE(many.find(" and 88 more"), std::string::npos);
}

}  // namespace
}  // namespace lode::ingest
