#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace lode {

/// Recognizes a compressed file or an archive by its first bytes.
/// @param head  first bytes of the file; 262 bytes suffice to recognize all formats.
/// @return rest of an error message that begins with the file's name: the format and the command that unpacks
/// the file. Returns nothing for other files.
std::optional<std::string> packedFileInWords(const std::filesystem::path& path, std::string_view head);

}  // namespace lode
