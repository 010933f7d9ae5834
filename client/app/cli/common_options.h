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
  std::string camera_file;  ///< empty: a camera that frames the model
  std::string up_text;      ///< --up of that camera, of light and of orbiting; empty: guessed
  std::string token_file;
  std::string ca_file;
  std::string cache_text;  ///< --cache: a folder, "off", or empty for the user's cache
  bool offline = false;
  bool fade = true;  ///< fade nodes in and out in a window, if frames are fast enough
  float pixels = 1;
  double timeout_s = 120;

  PictureSize size() const { return parseSize(size_text); }
  std::chrono::milliseconds timeout() const;
  /// Returns the memory budget, the token from --token-file or LODESTREAM_TOKEN, the CA file, and the cache
  /// of blobs, which only targets on a server use. @throws Error.
  stream::StreamOptions streamOptions() const;
};

/// Declares the options of every client command: the target, --timeout, --token-file, --ca-file, --version.
/// @param target_form  syntax of the target for the help text.
void addServerOptions(CLI::App& command, CommonOptions& options, const char* target_form);

/// Kinds of TARGET that a command accepts.
enum class Takes : uint8_t { kModels, kScenesToo };

/// Declares addServerOptions(), --camera, --up, --size, --pixels, --memory-budget, --cache and --offline.
void addCommonOptions(CLI::App& command, CommonOptions& options, Takes takes = Takes::kModels);

/// Declares --no-fade for commands that draw.
void addFadeOption(CLI::App& command, CommonOptions& options);

// Each adds a subcommand whose callback does the work and may set the exit status. runCommandLine() prints an
// Error that the callback throws.
void declareFetch(CLI::App& program, int& exit_status);
void declareList(CLI::App& program, int& exit_status);

}  // namespace lode::app
