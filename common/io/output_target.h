#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>

namespace lode {

/// Origin of an output's name.
enum class OutputName : uint8_t {
  kTyped,   ///< name that the user typed: see findOutput()
  kDerived  ///< name that the program derived from another: see findSideFile()
};

/// The output of a command after resolving links.
struct OutputTarget {
  std::filesystem::path path;  ///< file to write, after following symbolic links; the file need not exist
  bool is_stream = false;      ///< true for a pipe or a character device, which is never replaced
};

/// Follows the symbolic links in all parts of a path, even if the last link points to a missing file.
/// @throws Error kIo for a loop of links, and for a link that another user owns in a sticky folder such as
/// /tmp: the kernel does not follow such a link either.
std::filesystem::path followLinks(const std::filesystem::path& asked);

/// Follows symbolic links to the file to write.
/// @throws Error kUsage for an empty name and for anything but a file, a pipe or a character device; kIo as
/// followLinks().
OutputTarget findOutput(const std::filesystem::path& asked);

/// Checks a file whose name the program derived from an output, such as an image beside a mesh. The user has
/// not typed the name, so only a regular file of this user may be replaced; no link is followed.
/// @return the path, after following links in the names of folders. @throws Error kIo.
std::filesystem::path findSideFile(const std::filesystem::path& path);

/// Returns the extension in lower case with its dot: ".png" for "a.PNG". Returns an empty string if the name
/// has no extension.
std::string fileEnding(const std::filesystem::path& path);

/// Returns true if a path, under any name, leads to this process's standard output.
bool isStandardOutput(const std::filesystem::path& output) noexcept;

/// Returns the stream for a command's report: stdout, or stderr if the output is stdout. Call it before
/// writing the output. @throws Error kUsage if the output is stdout and the report is JSON.
std::FILE* reportStream(const std::filesystem::path& output, bool as_json);

/// Refuses an output if no image files can be written beside it.
/// @throws Error kUsage if the output is a pipe or a device.
void refuseFilesBesideStream(const std::filesystem::path& output);

}  // namespace lode
