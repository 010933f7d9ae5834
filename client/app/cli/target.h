#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <variant>

#include "client/stream/served_model.h"

namespace lode::app {

// Commands always read models from a server. To read a local StoreFile or PlyFile, a command starts a child
// server (child_server.h).
struct StoreFile {
  std::filesystem::path path;
};
struct PlyFile {
  std::filesystem::path path;
  std::filesystem::path textures_folder = {};  ///< folder to search first for the PLY's images; empty: none
  bool preview_only = false;                   ///< true to use the file's preview as its store
};
using Target = std::variant<stream::ServedModel, StoreFile, PlyFile>;

/// Returns true if a target is a scene file (scene_file.h).
bool namesScene(std::string_view text);

/// Returns true if a word can only be a TARGET, not a mistyped command: an address, a path with a slash or a
/// dot, the name of a file, or "-".
bool looksLikeTarget(std::string_view word);

/// Returns a target's name, which does not depend on the working folder: a file's absolute path.
std::string fullName(std::string_view target);

/// Parses a TARGET. @param textures_folder  folder to search first for the images of a PLY; empty: none.
/// @throws Error kUsage for an invalid target, kIo for a missing file, kInput for a file of another format
/// (common/io/foreign_file.h).
Target parseTarget(std::string_view text, const std::filesystem::path& textures_folder = {});
/// Parses lode://host[:port] or lodes://host[:port]. The result has an empty model name. @throws Error
/// kUsage.
stream::ServedModel parseServerUrl(std::string_view text);

/// Checks that an output file would not replace an input file. @throws Error kUsage if both are the same
/// file.
void refuseToReplace(std::string_view input, const std::filesystem::path& output);

}  // namespace lode::app
