#pragma once

#include <filesystem>
#include <string_view>
#include <variant>

#include "client/stream/served_model.h"

namespace lode::app {

// A command works on a model on a server, or on a local file that a child server serves.
struct StoreFile {
  std::filesystem::path path;
};
struct PlyFile {
  std::filesystem::path path;
};
using Target = std::variant<stream::ServedModel, StoreFile, PlyFile>;

/// Returns true if a target is a scene file (scene_file.h).
bool namesScene(std::string_view text);

/// Parses a TARGET. @throws Error kUsage for an invalid target, kIo for a missing file.
Target parseTarget(std::string_view text);
/// Parses lode://host[:port] or lodes://host[:port]; the model's name stays empty. @throws Error kUsage.
stream::ServedModel parseServerUrl(std::string_view text);

/// @throws Error kUsage if the output file is the input file, which it would replace.
void refuseToReplace(std::string_view input, const std::filesystem::path& output);

}  // namespace lode::app
