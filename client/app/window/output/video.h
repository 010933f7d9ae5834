#pragma once

#include <filesystem>
#include <string>

namespace lode::app {

/// ffmpeg in one of the folders that PATH names. @throws Error kIo if there is none, with what to do instead.
std::filesystem::path findFfmpeg(const std::string& search_path);

/// Makes a video of frame_000000.png, frame_000001.png, ... in a folder; it appears under its name when it is
/// whole. @throws Error kIo with what ffmpeg said.
void makeVideo(const std::filesystem::path& ffmpeg, const std::filesystem::path& frames, double fps,
               const std::filesystem::path& output);

}  // namespace lode::app
