#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace lode::app {

/// Checks the output file of a picture before the work begins. A pipe or a device may have any name.
/// @throws Error kUsage if the file name does not end in .png, or if the file is a folder or the target.
void checkPictureFile(std::string_view target, const std::filesystem::path& picture);

/// Returns a file name with the current local time, for example "lodestream-20261125-140039.png" for the
/// ending "png".
std::string timedName(const std::string& ending);

/// Returns "frame_000012.png" for frame 12.
std::string frameName(size_t frame);

/// Creates the folder for the frames of a film, with any missing parent folders. @throws Error kIo.
void makeFilmFolder(const std::filesystem::path& folder);

/// Rejects a folder that contains frames of another film beyond the last frame of the new film, because a
/// video made from the folder would include them.
/// @param frames  number of frames of the new film.
/// @throws Error kUsage, kIo.
void refuseOtherFilm(const std::filesystem::path& folder, size_t frames);

}  // namespace lode::app
