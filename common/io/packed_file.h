#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace lode {

/// Recognizes a compressed file or an archive by its first bytes.
/// @param head  first bytes of the file, at best 262 or more.
/// @return the end of a message that begins with the file's name: what the file is and the command that
/// unpacks it; nothing for other files.
std::optional<std::string> packedFileInWords(const std::filesystem::path& path, std::string_view head);

}  // namespace lode
