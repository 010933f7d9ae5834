#pragma once

#include <filesystem>
#include <string_view>

namespace lode::app {

/// Said before the work that a picture takes.
/// @throws Error kUsage for a file that is not called a PNG, a folder, and the target's own file; a pipe or a
/// device may be called anything.
void checkPictureFile(std::string_view target, const std::filesystem::path& picture);

}  // namespace lode::app
