#pragma once

#include <filesystem>
#include <string_view>
#include <variant>

#include "client/stream/served_model.h"

namespace lode::app {

/// What a command works on: a model on a server, or a local file that a child server will serve.
struct StoreFile {
  std::filesystem::path path;
};
struct PlyFile {
  std::filesystem::path path;
};
using Target = std::variant<stream::ServedModel, StoreFile, PlyFile>;

/// A scene's file: see scene_file.h.
bool namesScene(std::string_view text);

/// @throws Error kUsage for what cannot be a target, kIo for a file that is not there.
Target parseTarget(std::string_view text);
/// lode://host[:port] or lodes://host[:port] without a model, whose name stays empty. @throws Error kUsage.
stream::ServedModel parseServerUrl(std::string_view text);

/// @param input  a target or another file that is read.
/// @throws Error kUsage if the output is that file, which it would replace.
void refuseToReplace(std::string_view input, const std::filesystem::path& output);

}  // namespace lode::app
