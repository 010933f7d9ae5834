#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace lode {

/// Number of bytes from the start of a file that foreignFileInWords() examines.
constexpr size_t kForeignHeadBytes = 512;

/// Recognizes a file that is neither a PLY file nor a store: a mesh of another format, a point cloud, a
/// picture, a compressed file, an archive, a web page, a Git LFS pointer or an empty file. Uses the first
/// bytes; the name's ending matters only for formats without a signature (OBJ, OFF, STL and glTF) and for
/// formats that share a signature. Never reads a number from the file. Thread safe.
/// @param head  first bytes of the file, kForeignHeadBytes or all that it has; bytes after these are ignored.
/// @return rest of an error message that begins with the file's name: the format, and the command or the
/// programs that convert it. Returns nothing for PLY files, stores and unknown files.
std::optional<std::string> foreignFileInWords(const std::filesystem::path& path, std::string_view head);

}  // namespace lode
