#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

namespace lode {

/// What a file is written to that was asked for by a name.
struct OutputTarget {
  std::filesystem::path path;  ///< behind the links that the name leads through; there may be nothing yet
  bool is_stream = false;      ///< a pipe or a character device: written straight, never replaced
};

/// Follows a name's links to what is to be written.
/// @throws Error kUsage for an empty name and for what is neither file, pipe nor character device, kIo for
/// links that lead in circles.
OutputTarget findOutput(const std::filesystem::path& asked);

/// A file name's ending with its dot, in small letters: ".png" of "a.PNG"; empty where it has none.
std::string fileEnding(const std::filesystem::path& path);

/// Whether it is this process's standard output, whatever that is and by whatever name.
bool isStandardOutput(const std::filesystem::path& output) noexcept;

/// Where to say what was written: stdout, or stderr if the output is stdout itself. To be asked before it is
/// written. @throws Error kUsage in that case if it is to be said as JSON, which is for stdout.
std::FILE* reportStream(const std::filesystem::path& output, bool as_json);

/// @throws Error kUsage if files can be written beside no such output: a pipe or a device.
void refuseFilesBesideStream(const std::filesystem::path& output);

}  // namespace lode
