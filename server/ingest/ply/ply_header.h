#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace lode::ingest {

constexpr size_t kMaxPlyHeaderBytes = 1u << 20;
constexpr size_t kMaxPlyElements = 256;
constexpr size_t kMaxPlyProperties = 4096;  ///< limit of properties per element

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };
enum class PlyType : uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// Returns the size of a value in a binary body.
size_t plyTypeBytes(PlyType type) noexcept;
bool isFloating(PlyType type) noexcept;
/// Returns the traditional name of a type: char, uchar, short, ...
const char* plyTypeName(PlyType type) noexcept;

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;  ///< type of the value, or of a list's items
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  ///< type of a list's count; never a floating type
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;  ///< not empty if count > 0
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;   ///< elements with distinct names
  std::vector<std::string> comments;  ///< text of `comment` and `obj_info`, trimmed
  /// Names in `comment TextureFile NAME`, trimmed; "<this>" is replaced by the PLY file's name without
  /// extension.
  std::vector<std::string> texture_files;
  uint64_t body_offset = 0;  ///< bytes from the start of the file
  uint64_t header_lines = 0;

  /// Returns the element with this name, or null.
  const PlyElement* find(std::string_view name) const noexcept;
};

/// Reads the header of a PLY file with CR, LF, CRLF or mixed line ends. A binary body begins right after the
/// line end of `end_header`. CR LF after `end_header` counts as one line end, unless all earlier lines end in
/// CR alone; then LF is the first byte of the body.
/// @throws Error kIo if the path is not a readable file; kInput if the header is invalid, with line, problem
/// and remedy.
PlyHeader readPlyHeader(const std::filesystem::path& path);

}  // namespace lode::ingest
