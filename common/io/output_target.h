#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

namespace lode {

/// The output of a command after resolving links.
struct OutputTarget {
  std::filesystem::path path;  ///< file to write, after following symbolic links; the file need not exist
  bool is_stream = false;      ///< true for a pipe or a character device, which is never replaced
};

/// Follows symbolic links to the file to write.
/// @throws Error kUsage for an empty name and for anything but a file, a pipe or a character device; kIo for
/// a loop of links.
OutputTarget findOutput(const std::filesystem::path& asked);

/// Returns the extension in lower case with its dot: ".png" for "a.PNG". Returns an empty string if the name
/// has no extension.
std::string fileEnding(const std::filesystem::path& path);

/// Returns true if a path, under any name, leads to this process's standard output.
bool isStandardOutput(const std::filesystem::path& output) noexcept;

/// Returns the stream for a command's report: stdout, or stderr if the output is stdout. Call it before
/// writing. @throws Error kUsage if the output is stdout and the report is JSON.
std::FILE* reportStream(const std::filesystem::path& output, bool as_json);

/// Refuses an output beside which no image files can be written.
/// @throws Error kUsage if the output is a pipe or a device.
void refuseFilesBesideStream(const std::filesystem::path& output);

}  // namespace lode
