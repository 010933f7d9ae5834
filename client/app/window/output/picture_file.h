#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace lode::app {

/// Checks a picture's file before the work that the picture takes. A pipe or a device may have any name.
/// @throws Error kUsage if the file does not end in .png, is a folder, or is the target's own file.
void checkPictureFile(std::string_view target, const std::filesystem::path& picture);

/// Returns "lodestream-20261125-140039.png" for the ending "png" and the local time now.
std::string timedName(const std::string& ending);

/// Returns "frame_000012.png" for frame 12.
std::string frameName(size_t frame);

/// Makes the folder for a film's frames, and the folders above it. @throws Error kIo.
void makeFilmFolder(const std::filesystem::path& folder);

/// Refuses a folder with later frames of another film: they would become part of a video made of the folder.
/// @param frames  number of frames of the new film.
/// @throws Error kUsage, kIo.
void refuseOtherFilm(const std::filesystem::path& folder, size_t frames);

}  // namespace lode::app
