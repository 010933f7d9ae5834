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

/// "WxH". @throws Error kUsage.
PictureSize parseSize(std::string_view text);

/// What view, render and fetch understand alike.
struct CommonOptions {
  std::string target;
  std::string size_text = "1280x720";
  std::string memory_text;
  std::string camera_file;  ///< empty: the camera that frames the model
  std::string up_text;      ///< of that camera, of light and of turning; empty: guessed
  std::string token_file;
  std::string ca_file;
  std::string cache_text;  ///< --cache: a folder, "off", or empty for the user's own
  bool offline = false;
  bool fade = true;  ///< in a window: what arrives and leaves, where frames are fast enough to show it
  float pixels = 1;
  double timeout_s = 120;

  PictureSize size() const { return parseSize(size_text); }
  std::chrono::milliseconds timeout() const;
  /// Memory budget, the token from the file or LODESTREAM_TOKEN, authorities for TLS, and the cache of blobs,
  /// which only targets on a server have. @throws Error.
  stream::StreamOptions streamOptions() const;
};

/// Declares what every client command has: the target (as the command names it), --timeout and --token-file.
void addServerOptions(CLI::App& command, CommonOptions& options, const char* target_form);

/// What may be a command's TARGET.
enum class Takes : uint8_t { kModels, kScenesToo };

/// Declares TARGET, --camera, --size, --pixels, --timeout, --memory-budget and --token-file on a subcommand.
void addCommonOptions(CLI::App& command, CommonOptions& options, Takes takes = Takes::kModels);

/// Declares --no-fade, of what has a window.
void addFadeOption(CLI::App& command, CommonOptions& options);

/// A subcommand is declared by a function like this: it adds itself to the program with a callback that does
/// the work and sets the exit status; an Error that leaves the callback is printed by main().
using DeclareCommand = void (*)(CLI::App& program, int& exit_status);

void declareFetch(CLI::App& program, int& exit_status);
void declareList(CLI::App& program, int& exit_status);
void declareReplay(CLI::App& program, int& exit_status);

}  // namespace lode::app
