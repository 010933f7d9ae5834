#pragma once

#include <filesystem>

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

}  // namespace lode
