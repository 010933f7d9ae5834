#include "client/app/window/output/video.h"

#include <cstdio>
#include <sstream>
#include <system_error>

#include <unistd.h>

#include "client/app/cli/child_process.h"
#include "common/error.h"

namespace lode::app {

namespace {

/// Escapes each % in a path, because ffmpeg would read it as the start of a file number pattern.
std::string escapePattern(const std::filesystem::path& path) {
  std::string escaped;
  for (const char c : path.string()) escaped += c == '%' ? "%%" : std::string(1, c);
  return escaped;
}

}  // namespace

std::filesystem::path findFfmpeg(const std::string& search_path) {
  std::istringstream folders(search_path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path program = std::filesystem::path(folder) / "ffmpeg";
    if (!folder.empty() && access(program.c_str(), X_OK) == 0) return program;
  }
  throw Error(
      ErrorCode::kIo,
      "--video needs ffmpeg, which is not installed: install the package ffmpeg, or write pictures with "
      "--frames DIR");
}

void makeVideo(const std::filesystem::path& ffmpeg, const std::filesystem::path& frames, double fps,
               const std::filesystem::path& output) {
  const std::filesystem::path folder = std::filesystem::absolute(frames), unfinished = folder / "video.mp4";
  char rate[32];
  std::snprintf(rate, sizeof rate, "%.6g", fps);
  // Most players need yuv420p, which needs an even width and height. Write the colour matrix into the file,
  // because players would otherwise guess it from the picture size.
  ChildProcess encoder(std::filesystem::absolute(ffmpeg),
                       {"-y",
                        "-loglevel",
                        "error",
                        "-framerate",
                        rate,
                        "-i",
                        escapePattern(folder) + "/frame_%06d.png",
                        "-vf",
                        "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv",
                        "-c:v",
                        "libx264",
                        "-crf",
                        "18",
                        "-pix_fmt",
                        "yuv420p",
                        "-colorspace",
                        "bt709",
                        "-color_primaries",
                        "bt709",
                        "-color_trc",
                        "bt709",
                        "-color_range",
                        "tv",
                        "-movflags",
                        "+faststart",
                        "-f",
                        "mp4",
                        unfinished},
                       ChildProcess::Messages::kKeep);
  const int status = encoder.wait();
  std::error_code failed;
  if (status == 0) std::filesystem::rename(unfinished, output, failed);
  if (status == 0 && !failed) return;
  const std::string said = status == 0 ? failed.message() : encoder.lastMessage();
  std::filesystem::remove(unfinished, failed);
  throw Error(ErrorCode::kIo, output.string() + " cannot be made by ffmpeg (" +
                                  (said.empty() ? "exit status " + std::to_string(status) : said) +
                                  "): choose another place, or write pictures with --frames DIR");
}

}  // namespace lode::app
