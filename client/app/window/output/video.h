#pragma once

#include <filesystem>
#include <string>

namespace lode::app {

/// Finds ffmpeg in the folders of a search path. @param search_path  value of PATH.
/// @throws Error kIo if no folder contains ffmpeg.
std::filesystem::path findFfmpeg(const std::string& search_path);

/// Encodes frame_000000.png, frame_000001.png, ... of a folder as a video. The video is written into this
/// folder, which must be on the output's file system, and is renamed to the output when it is complete.
/// ffmpeg receives absolute paths, which it cannot mistake for options or protocols.
/// @throws Error kIo with ffmpeg's message.
void makeVideo(const std::filesystem::path& ffmpeg, const std::filesystem::path& frames, double fps,
               const std::filesystem::path& output);

}  // namespace lode::app
