#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "client/app/cli/target.h"
#include "client/stream/streamer.h"
#include "common/io/copied_input.h"

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
  /// Value of --camera: file with a camera path; if empty, a default camera shows the whole model.
  std::string camera_file;
  /// Value of --up: the up axis of the default camera, the light and orbiting; if empty, it is guessed.
  std::string up_text;
  std::string token_file;
  std::string ca_file;
  std::string cache_text;                 ///< value of --cache: a folder or "off"; if empty, the user's cache
  std::filesystem::path textures_folder;  ///< value of --textures: folder to search first for images
  bool preview = false;                   ///< true to use the preview of a PLY file as its store
  bool offline = false;
  bool fade = true;  ///< true to cross-fade LODs in the window while frames are fast enough
  float pixels = 1;
  double timeout_s = 120;

  /// Copy of standard input, if the target was "-". Set by takeStandardInput().
  std::shared_ptr<const CopiedInput> copied;

  PictureSize size() const { return parseSize(size_text); }
  std::chrono::milliseconds timeout() const;
  /// Returns stream options with the memory budget, the CA file, and the token from --token-file or
  /// LODESTREAM_TOKEN. If the target is on a server, also sets the folder of the blob cache. @throws Error.
  stream::StreamOptions streamOptions() const;
};

/// Declares the options of every client command: the target, --timeout, --token-file, --ca-file, --version.
/// If the parsed options include a token for a target that may be on a server, the files that the process
/// creates from then on are readable by this user only.
/// @param target_form  syntax of the target for the help text.
void addServerOptions(CLI::App& command, CommonOptions& options, const char* target_form);

/// Kinds of TARGET that a command accepts.
enum class Takes : uint8_t {
  kModels,    ///< models only
  kScenesToo  ///< models and scene files
};

/// Declares the options of addServerOptions(), and --camera, --up, --size, --pixels, --memory-budget,
/// --cache, --textures and --offline.
void addCommonOptions(CLI::App& command, CommonOptions& options, Takes takes = Takes::kModels);

/// If the target is standard input ("-" or "/dev/stdin"), copies it into the cache and makes the copy the
/// target. @throws Error as copyStandardInput() does.
void takeStandardInput(CommonOptions& options);

/// Declares --preview for commands that show a model once.
void addPreviewOption(CLI::App& command, CommonOptions& options);

/// Returns the target of the options, or of a scene's model with the given name. @throws Error as
/// parseTarget() does.
Target targetOf(const CommonOptions& options, std::string_view name);

/// Declares --no-fade for commands that draw.
void addFadeOption(CLI::App& command, CommonOptions& options);

// Each of these functions adds a subcommand. The callback of the subcommand does the work and can set the
// exit status. If the callback throws an Error, runCommandLine() prints the message and the remedy.
void declareFetch(CLI::App& program, int& exit_status);
void declareList(CLI::App& program, int& exit_status);
void declareStore(CLI::App& program, int& exit_status);

}  // namespace lode::app
