#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace lode::ingest {

constexpr size_t kMaxPlyHeaderBytes = 1u << 20;
constexpr size_t kMaxPlyElements = 256;
constexpr size_t kMaxPlyProperties = 4096;  ///< of one element

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };
enum class PlyType : uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// Size of a value in a binary body.
size_t plyTypeBytes(PlyType type) noexcept;
bool isFloating(PlyType type) noexcept;
/// The type's name as headers spell it since 1998: char, uchar, short, ...
const char* plyTypeName(PlyType type) noexcept;

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;  ///< of the value, or of a list's items
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  ///< of a list: never a floating type
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;  ///< never empty where count > 0
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;        ///< no two of the same name
  std::vector<std::string> comments;       ///< of `comment` and `obj_info`, trimmed
  std::vector<std::string> texture_files;  ///< of `comment TextureFile NAME`: trimmed, inner blanks kept,
                                           ///< "<this>" being the file's own name without its extension
  uint64_t body_offset = 0;                ///< bytes from the file's start
  uint64_t header_lines = 0;

  /// The element of this name, or null.
  const PlyElement* find(std::string_view name) const noexcept;
};

/// Reads the header of a PLY file: CR, LF, CRLF and mixed line ends.
/// A binary body begins right behind the line end of `end_header`. CR LF there is one line end, unless all
/// lines before end in a bare CR: then the LF is the body's first byte.
/// @throws Error kIo (no file, a directory) or kInput (what is wrong, at which line, and what to do).
PlyHeader readPlyHeader(const std::filesystem::path& path);

}  // namespace lode::ingest
