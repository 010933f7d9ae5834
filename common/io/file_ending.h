#pragma once

#include <filesystem>
#include <string>

namespace lode {

/// A file name's ending with its dot, in small letters: ".png" of "a.PNG"; empty where it has none.
std::string fileEnding(const std::filesystem::path& path);

}  // namespace lode
