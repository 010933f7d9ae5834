#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/ply/ply_reader.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {

/// A temporary folder for PLY files.
class PlyFolder : public test::WorkFolder {
 public:
  std::filesystem::path write(const std::string& bytes, const std::string& name = "mesh.ply") const {
    std::ofstream(*this / name, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return *this / name;
  }
};

/// Reads a whole file.
struct PlyContent {
  std::vector<PlyVertex> vertices;
  std::vector<std::vector<uint64_t>> faces;
  std::vector<glm::vec2> texture;
  std::vector<uint16_t> materials;
  std::vector<glm::u8vec4> colours;  ///< colours of faces
  AttributeSet attributes;
  PlyCounts counts;
  PlyHeader header;
};

inline PlyContent readPly(const std::filesystem::path& path, PlyReadOptions options = {}) {
  PlyContent content;
  PlyReader reader(path, options);
  content.attributes = reader.attributes();
  content.header = reader.header();
  content.counts = reader.read(
      [&](uint64_t first, std::span<const PlyVertex> rows) {
        EXPECT_EQ(first, content.vertices.size());
        content.vertices.insert(content.vertices.end(), rows.begin(), rows.end());
      },
      [&](const PlyFaces& batch) {
        const uint64_t* corner = batch.corners.data();
        for (const uint32_t count : batch.corner_counts) {
          content.faces.emplace_back(corner, corner + count);
          corner += count;
        }
        EXPECT_EQ(corner, batch.corners.data() + batch.corners.size());
        content.texture.insert(content.texture.end(), batch.texture.begin(), batch.texture.end());
        content.materials.insert(content.materials.end(), batch.materials.begin(), batch.materials.end());
        content.colours.insert(content.colours.end(), batch.colours.begin(), batch.colours.end());
      });
  return content;
}

inline PlyContent readPlyBytes(const std::string& bytes, PlyReadOptions options = {}) {
  const PlyFolder folder;
  return readPly(folder.write(bytes), options);
}

/// Reads a file and returns the message of its Error, which must be one line. Fails the test if there is
/// none.
inline std::string plyErrorOf(const std::string& bytes, PlyReadOptions options = {}) {
  try {
    readPlyBytes(bytes, options);
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.code(), ErrorCode::kInput) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_NE(message.find("mesh.ply"), std::string::npos) << message;
    EXPECT_NE(message.find(';'), std::string::npos) << "no remedy: " << message;
    return message;
  }
  ADD_FAILURE() << "no Error";
  return {};
}

inline void expectMentions(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << part << " in: " << message;
}

/// Content of a PLY file, which can be written in any encoding.
struct PlySource {
  struct Property {
    std::string name;
    std::string type;
    std::string count_type;  ///< empty if not a list
  };
  struct Element {
    std::string name;
    std::vector<Property> properties;
    std::vector<std::vector<std::vector<double>>> rows;  ///< values by row and property
  };
  std::vector<Element> elements;

  std::string encode(PlyEncoding encoding) const {
    static const char* const kNames[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    std::string out = std::string("ply\nformat ") + kNames[static_cast<int>(encoding)] + " 1.0\n";
    for (const Element& element : elements) {
      out += "element " + element.name + " " + std::to_string(element.rows.size()) + "\n";
      for (const Property& property : element.properties) {
        out += "property " + (property.count_type.empty() ? "" : "list " + property.count_type + " ") +
               property.type + " " + property.name + "\n";
      }
    }
    out += "end_header\n";
    for (const Element& element : elements) {
      for (const auto& row : element.rows) appendRow(out, element, row, encoding);
    }
    return out;
  }

 private:
  static void appendRow(std::string& out, const Element& element, const std::vector<std::vector<double>>& row,
                        PlyEncoding encoding) {
    for (size_t i = 0; i < element.properties.size(); ++i) {
      const Property& property = element.properties[i];
      if (!property.count_type.empty())
        append(out, property.count_type, static_cast<double>(row[i].size()), encoding);
      for (const double value : row[i]) append(out, property.type, value, encoding);
    }
    if (encoding == PlyEncoding::kAscii) out.back() = '\n';
  }

  template <class T>
  static void appendAs(std::string& out, double value, PlyEncoding encoding) {
    char bytes[sizeof(T)];
    const T typed = static_cast<T>(value);
    std::memcpy(bytes, &typed, sizeof(T));
    if (encoding == PlyEncoding::kBigEndian) std::reverse(bytes, bytes + sizeof(T));
    out.append(bytes, sizeof(T));
  }

  static void append(std::string& out, const std::string& type, double value, PlyEncoding encoding) {
    if (encoding == PlyEncoding::kAscii) {
      char text[32];
      std::snprintf(text, sizeof(text), "%.17g ", value);
      out += text;
    } else if (type == "char" || type == "int8") {
      appendAs<int8_t>(out, value, encoding);
    } else if (type == "uchar" || type == "uint8") {
      appendAs<uint8_t>(out, value, encoding);
    } else if (type == "short" || type == "int16") {
      appendAs<int16_t>(out, value, encoding);
    } else if (type == "ushort" || type == "uint16") {
      appendAs<uint16_t>(out, value, encoding);
    } else if (type == "int" || type == "int32") {
      appendAs<int32_t>(out, value, encoding);
    } else if (type == "uint" || type == "uint32") {
      appendAs<uint32_t>(out, value, encoding);
    } else if (type == "float" || type == "float32") {
      appendAs<float>(out, value, encoding);
    } else {
      appendAs<double>(out, value, encoding);
    }
  }
};

constexpr PlyEncoding kPlyEncodings[] = {PlyEncoding::kAscii, PlyEncoding::kLittleEndian,
                                         PlyEncoding::kBigEndian};

/// A minimal tetrahedron.
inline PlySource tetrahedron() {
  return {
      {{"vertex",
        {{"x", "float", ""}, {"y", "float", ""}, {"z", "float", ""}},
        {{{0}, {0}, {0}}, {{1}, {0}, {0}}, {{0}, {1}, {0}}, {{0}, {0}, {1}}}},
       {"face", {{"vertex_indices", "int", "uchar"}}, {{{0, 2, 1}}, {{0, 1, 3}}, {{1, 2, 3}}, {{2, 0, 3}}}}}};
}

/// A file with everything that the reader reads, as lists and scalars of all types, mixed with skipped
/// properties.
inline PlySource everything() {
  return {
      {{"vertex",
        {{"x", "double", ""},
         {"confidence", "float", ""},
         {"y", "double", ""},
         {"z", "float", ""},
         {"nx", "float", ""},
         {"ny", "float", ""},
         {"nz", "float", ""},
         {"red", "ushort", ""},
         {"green", "float", ""},
         {"blue", "uchar", ""},
         {"alpha", "int", ""},
         {"u", "float", ""},
         {"v", "float", ""}},
        {{{0.1}, {1}, {0}, {0}, {0}, {0}, {1}, {65535}, {0.5}, {1}, {255}, {0.25}, {0.75}},
         {{1}, {1}, {1e6}, {0}, {0}, {1}, {0}, {257}, {1}, {2}, {300}, {0.5}, {0.5}},
         {{0}, {1}, {1}, {-2}, {1}, {0}, {0}, {0}, {0}, {3}, {-1}, {1}, {0}},
         {{0}, {1}, {0}, {1}, {1}, {0}, {0}, {100}, {0.1}, {4}, {7}, {1}, {1}}}},
       {"camera", {{"views", "short", "ushort"}, {"focal", "double", ""}}, {{{1, 2, 3}, {0.5}}, {{}, {0.5}}}},
       {"face",
        {{"flags", "short", ""},
         {"vertex_index", "ushort", "int"},
         {"weights", "double", "uchar"},
         {"texcoord", "float", "uchar"},
         {"texnumber", "int", ""}},
        {{{7}, {0, 1, 2}, {1, 2}, {0, 0, 1, 0, 0, 1}, {3}},
         {{7}, {0, 1, 2, 3}, {}, {0, 0, 1, 0, 0, 1, 0.5, 0.5}, {-1}},
         {{7}, {1, 2, 3}, {5}, {}, {0}}}},
       {"tristrips", {{"vertex_indices", "int", "uint"}}, {{{0, 1, 2, 3, -1, 3, 2, 1}}}}}};
}

}  // namespace lode::ingest
