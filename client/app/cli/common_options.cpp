#include "client/app/cli/common_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <system_error>
#include <utility>

#include <CLI/CLI.hpp>
#include <sys/stat.h>

#include "client/app/cli/built_store.h"
#include "client/app/cli/store_cache.h"
#include "client/app/cli/target.h"
#include "client/core/view/camera_path.h"
#include "common/byte_size.h"
#include "common/command_line.h"
#include "common/error.h"
#include "common/io/own_folder.h"
#include "common/printable.h"
#include "proto/limits.h"

namespace lode::app {
namespace {

constexpr uint64_t kMinMemoryBudgetBytes = 16u << 20;

/// Returns true if the text is a line of a server's token file: TOKEN EXPIRY MODEL…
bool isGrant(std::string_view text) {
  const size_t first = text.find(' ');
  if (first == std::string_view::npos) return false;
  const std::string_view rest = text.substr(first + 1);
  const std::string_view expiry = rest.substr(0, rest.find(' '));
  const bool is_time =
      !expiry.empty() && expiry.front() >= '0' && expiry.front() <= '9' && expiry.back() == 'Z';
  return expiry.size() < rest.size() && (expiry == "never" || is_time);
}

/// Returns the token if it is valid. @param source  file or variable that contained the token, for error
/// messages. @throws Error kUsage if the token is invalid.
std::string checkedToken(std::string token, const std::string& source) {
  if (token.size() > proto::kMaxTokenBytes || !isPrintableUtf8(token) || isGrant(token))
    throw Error(ErrorCode::kUsage, source +
                                       ": is not one token; write only the token, in one line of at most " +
                                       std::to_string(proto::kMaxTokenBytes) + " bytes of printable UTF-8");
  return token;
}

std::string readToken(const std::string& file) {
  if (file.empty()) {
    const char* token = std::getenv("LODESTREAM_TOKEN");
    return checkedToken(token ? token : "", "LODESTREAM_TOKEN");
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw Error(ErrorCode::kIo, file + ": cannot open the token file; check the name and its permissions");
  std::string token(proto::kMaxTokenBytes + 2, '\0');
  stream.read(token.data(), static_cast<std::streamsize>(token.size()));
  token.resize(static_cast<size_t>(stream.gcount()));
  while (!token.empty() && (token.back() == '\n' || token.back() == '\r')) token.pop_back();
  if (token.empty()) throw Error(ErrorCode::kUsage, file + ": is not one token: the file is empty");
  return checkedToken(std::move(token), file);
}

std::filesystem::path chosenCache(const std::string& folder, bool offline) {
  if (!offline) stream::prepareCacheFolder(folder);
  return folder;
}

void warnOfOpenToken(const CommonOptions& options) {
  if (isOpenToOthers(options.token_file))
    std::fprintf(stderr,
                 "lodestream: warning: %s: other users can read or change this token file; chmod it to 600\n",
                 options.token_file.c_str());
}

/// If there is a token and the target may be on a server, makes all files that this process creates from now
/// on readable by this user only, because they may show a model that the token protects.
void keepFilesPrivate(const CommonOptions& options) {
  const char* const token = std::getenv("LODESTREAM_TOKEN");
  const bool has_token = !options.token_file.empty() || (token != nullptr && *token != '\0');
  const bool is_local = !options.target.empty() && options.target.find("://") == std::string::npos &&
                        !namesScene(options.target);
  constexpr mode_t kOthers = S_IRWXG | S_IRWXO;
  if (has_token && !is_local) ::umask(::umask(kOthers) | kOthers);
}

}  // namespace

PictureSize parseSize(std::string_view text) {
  PictureSize size;
  const char* const end = text.data() + text.size();
  const auto [cross, first] = std::from_chars(text.data(), end, size.width_px);
  bool good = first == std::errc() && cross != end && *cross == 'x';
  if (good) {
    const auto [last, second] = std::from_chars(cross + 1, end, size.height_px);
    good = second == std::errc() && last == end;
  }
  const auto fits = [](uint32_t side) { return side >= 1 && side <= core::kMaxPictureSidePx; };
  if (!good || !fits(size.width_px) || !fits(size.height_px))
    throw Error(ErrorCode::kUsage, "'" + std::string(text) +
                                       "' is not a size; write WIDTHxHEIGHT, such as 1280x720, " +
                                       "each side from 1 to " + std::to_string(core::kMaxPictureSidePx));
  return size;
}

std::chrono::milliseconds CommonOptions::timeout() const {
  return std::chrono::milliseconds(static_cast<int64_t>(std::ceil(timeout_s * 1000)));
}

stream::StreamOptions CommonOptions::streamOptions() const {
  stream::StreamOptions options;
  options.ca_file = ca_file;
  options.engine.session.token = readToken(token_file);
  if (!memory_text.empty()) options.engine.memory_budget_bytes = parseByteSize(memory_text);
  if (options.engine.memory_budget_bytes < kMinMemoryBudgetBytes)
    throw Error(ErrorCode::kUsage, "--memory-budget must be at least 16MiB");
  options.connect_timeout = std::min(options.connect_timeout, timeout());
  const bool on_server = target.find("://") != std::string::npos;
  if (on_server && cache_text != "off")
    options.cache_folder = cache_text.empty() ? ownCacheFolder() : chosenCache(cache_text, offline);
  options.engine.offline = offline;
  if (offline && options.cache_folder.empty())
    throw Error(
        ErrorCode::kUsage,
        "--offline shows cached parts of a model on a server: name such a model, and leave out --cache off");
  return options;
}

void addServerOptions(CLI::App& command, CommonOptions& options, const char* target_form) {
  command.add_option("target", options.target, target_form)->required()->type_name("TARGET");
  command.add_option("--timeout", options.timeout_s, "time limit in seconds")
      ->check(numberFrom(0.001, 1e6))
      ->capture_default_str();
  command.add_option("--token-file", options.token_file,
                     "file with the access token (default: the variable LODESTREAM_TOKEN)");
  command
      .add_option("--ca-file", options.ca_file,
                  "certificate authorities of lodes:// servers, in PEM (default: the system's)")
      ->type_name("FILE");
  command.set_version_flag("--version", "lodestream " LODE_VERSION);
  command.parse_complete_callback([&options] {
    warnOfOpenToken(options);
    keepFilesPrivate(options);
  });
}

void addCommonOptions(CLI::App& command, CommonOptions& options, Takes takes) {
  addServerOptions(
      command, options,
      takes == Takes::kScenesToo
          ? "lode://HOST[:PORT]/MODEL (lodes:// with TLS), a store, a PLY (-: from standard input) or a "
            "scene (.json)"
          : "lode://HOST[:PORT]/MODEL (lodes:// with TLS), a store or a PLY (-: from standard input)");
  auto* camera = command
                     .add_option("--camera", options.camera_file,
                                 "camera path (default: a camera that frames the model)")
                     ->type_name("PATH.json");
  auto* up = command.add_option("--up", options.up_text, "up axis of the model (default: guessed, y or z)")
                 ->type_name("y|z|x|-y|-z|-x");
  // Commands that draw accept --up together with --camera, because the light and orbiting need the axis.
  if (takes == Takes::kModels) up->excludes(camera);
  command.add_option("--size", options.size_text, "size of the picture")
      ->type_name("WxH")
      ->capture_default_str();
  command.add_option("--pixels", options.pixels, "largest error allowed in the picture")
      ->check(numberFrom(0.01, 1000.0))
      ->capture_default_str();
  command
      .add_option("--memory-budget", options.memory_text,
                  "memory for the model, including its copies on the GPU; at least 16MiB (default: 1G)")
      ->type_name("BYTES");
  command
      .add_option("--cache", options.cache_text,
                  "folder that caches blobs from servers; off: no cache (default: the user's cache)")
      ->type_name("DIR|off");
  addTexturesFolder(command, options.textures_folder);
  command.add_flag("--offline", options.offline, "show the blobs of the cache, without a server");
}

void addPreviewOption(CLI::App& command, CommonOptions& options) {
  command.add_flag("--preview", options.preview,
                   "show a PLY file as soon as it is read, by a coarse preview; its store is not built");
}

void takeStandardInput(CommonOptions& options) {
  if (!namesStandardInput(options.target)) return;
  options.copied = copyStandardInput();
  options.target = options.copied->path().string();
}

Target targetOf(const CommonOptions& options, std::string_view name) {
  Target target = parseTarget(name, options.textures_folder);
  if (auto* const ply = std::get_if<PlyFile>(&target)) ply->preview_only = options.preview;
  return target;
}

void addFadeOption(CLI::App& command, CommonOptions& options) {
  command.add_flag_callback(
      "--no-fade", [&options] { options.fade = false; }, "show new parts at once, without a cross-fade");
}

}  // namespace lode::app
