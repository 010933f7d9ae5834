#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace lode::ingest {

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };
enum class PlyType : uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;  ///< of the value, or of a list's items
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;
  std::vector<std::string> texture_files;  ///< of `comment TextureFile NAME`, blanks kept
  uint64_t body_offset = 0;                ///< bytes from the file's start
  uint64_t header_lines = 0;
};

/// Reads the header of a PLY file: CR, LF, CRLF and mixed line ends.
/// @throws Error kIo (no file, a directory) or kInput (what is wrong, at which line, and what to do).
PlyHeader readPlyHeader(const std::filesystem::path& path);

}  // namespace lode::ingest
