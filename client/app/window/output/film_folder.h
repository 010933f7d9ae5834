#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace lode::app {

/// "frame_000012.png".
std::string frameName(size_t frame);

/// The folder of a film's frames, with those above it. @throws Error kIo.
void makeFilmFolder(const std::filesystem::path& folder);

/// @param frames  of the film that is to be written there.
/// @throws Error kUsage if frames lie there that would stay behind its last one: whoever makes a video of all
/// would have them in it.
void refuseOtherFilm(const std::filesystem::path& folder, size_t frames);

}  // namespace lode::app
