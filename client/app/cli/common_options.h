#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "client/stream/streamer.h"

namespace CLI {
class App;
}

namespace lode::app {

struct PictureSize {
  uint32_t width_px = 1280, height_px = 720;
};

/// Parses "WxH". @throws Error kUsage.
PictureSize parseSize(std::string_view text);

/// Options that client commands share.
struct CommonOptions {
  std::string target;
  std::string size_text = "1280x720";
  std::string memory_text;
  /// Value of --camera: a file with a camera path; if empty, the camera frames the model.
  std::string camera_file;
  std::string up_text;  ///< value of --up: up axis of the framing camera, of the light and of orbiting; if
                        ///< empty, the axis is guessed
  std::string token_file;
  std::string ca_file;
  std::string cache_text;                 ///< value of --cache: a folder or "off"; if empty, the user's cache
  std::filesystem::path textures_folder;  ///< value of --textures: folder that is searched first for images
  bool offline = false;
  bool fade = true;  ///< true fades nodes in and out in the window, while frames are fast enough
  float pixels = 1;
  double timeout_s = 120;

  PictureSize size() const { return parseSize(size_text); }
  std::chrono::milliseconds timeout() const;
  /// Returns stream options with the memory budget, the CA file, and the token from --token-file or
  /// LODESTREAM_TOKEN. For a target on a server, also sets the cache of blobs. @throws Error.
  stream::StreamOptions streamOptions() const;
};

/// Declares the options of every client command: the target, --timeout, --token-file, --ca-file, --version.
/// Commands that parse a token write files and folders that only this user can read.
/// @param target_form  syntax of the target, as the help text shows it.
void addServerOptions(CLI::App& command, CommonOptions& options, const char* target_form);

/// Kinds of TARGET that a command accepts.
enum class Takes : uint8_t {
  kModels,    ///< models only
  kScenesToo  ///< models and scene files
};

/// Declares addServerOptions(), --camera, --up, --size, --pixels, --memory-budget, --cache, --textures and
/// --offline.
void addCommonOptions(CLI::App& command, CommonOptions& options, Takes takes = Takes::kModels);

/// Declares --no-fade for commands that draw.
void addFadeOption(CLI::App& command, CommonOptions& options);

// Each of these functions adds a subcommand. The callback of the subcommand does the work and can set the
// exit status. If the callback throws an Error, runCommandLine() prints the message and the remedy.
void declareFetch(CLI::App& program, int& exit_status);
void declareList(CLI::App& program, int& exit_status);

}  // namespace lode::app
