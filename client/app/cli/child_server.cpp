#include "client/app/cli/child_server.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>

#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "client/app/cli/cache_folder.h"
#include "common/blob.h"
#include "common/error.h"

namespace lode::app {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kReadyTimeout{60};
constexpr std::chrono::hours kLongestSilence{24 * 7};  // of a build
constexpr size_t kKeyDigits = 16;
constexpr size_t kTokenBytes = 32;

std::string childFailure(const ChildProcess& child, const std::string& what) {
  std::string said = child.lastMessage();
  constexpr std::string_view kPrefix = "lodestreamd: ";
  if (said.starts_with(kPrefix)) said.erase(0, kPrefix.size());
  return said.empty() ? what : said;
}

std::string makeToken() {
  std::array<std::byte, kTokenBytes> secret;
  if (getentropy(secret.data(), secret.size()) != 0)
    throw Error(ErrorCode::kIo, std::string("the system gives no random bytes: ") + std::strerror(errno));
  return toHex(nameBlob(secret));
}

stream::ServedModel readReadyLine(ChildProcess& child, const fs::path& store, const std::stop_token& stop) {
  const std::stop_callback end_child(stop, [&child] { child.terminate(); });
  const std::string line = child.readLine(kReadyTimeout);
  const auto json = nlohmann::ordered_json::parse(line, nullptr, false);
  if (line.empty() || !json.is_object() || !json.contains("listen") || !json["listen"].is_string() ||
      !json.contains("models") || !json["models"].is_array() || json["models"].size() != 1 ||
      !json["models"][0].is_string())
    throw Error(ErrorCode::kIo,
                childFailure(child, "lodestreamd did not get ready to serve " + store.string()));
  return {net::parseAddress(json["listen"].get<std::string>()), json["models"][0].get<std::string>()};
}

struct stat statOf(const fs::path& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0)
    throw Error(ErrorCode::kIo,
                path.string() + ": " + std::strerror(errno) + "; check the name and its permissions");
  return status;
}

std::string hashOf(const std::string& text) {
  return toHex(nameBlob(std::as_bytes(std::span(text)))).substr(0, kKeyDigits);
}

std::string describeVersion(const struct stat& status) {
  return std::to_string(status.st_size) + " " + std::to_string(status.st_mtim.tv_sec) + "." +
         std::to_string(status.st_mtim.tv_nsec);
}

/// Removes what was built of the same file before it changed.
void removeOthers(const fs::path& folder, const fs::path& keep) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.path() != keep) fs::remove_all(entry.path(), ignored);
}

void tell(const BuildWatch& watch, const std::string& line) {
  const auto json = nlohmann::ordered_json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("stage") || !json["stage"].is_string() ||
      !json.contains("fraction") || !json["fraction"].is_number())
    return;
  watch(json["stage"].get<std::string>(), std::clamp(json["fraction"].get<double>(), 0.0, 1.0));
}

fs::path buildIntoCache(const fs::path& ply, bool announce, const std::stop_token& stop,
                        const BuildWatch& watch) {
  const fs::path builder = siblingServer();
  const fs::path source = fs::absolute(ply).lexically_normal();
  const fs::path of_source = cacheFolder() / "stores" / hashOf(source.string());
  const std::string key = describeVersion(statOf(source)) + " " + describeVersion(statOf(builder));
  const fs::path folder = of_source / hashOf(key);
  const fs::path store = folder / (source.stem().string() + ".lode");
  if (fs::exists(store)) return store;

  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed)
    throw Error(ErrorCode::kIo, folder.string() + " cannot be made: " + failed.message() +
                                    "; set XDG_CACHE_HOME to a folder that can be written");
  const bool show_progress = announce && !watch && isatty(STDERR_FILENO) == 1;
  std::vector<std::string> arguments{"build", source.string(), "-o", store.string()};
  if (!show_progress) arguments.emplace_back(watch ? "--json-progress" : "--quiet");
  ChildProcess build(builder, arguments,
                     show_progress ? ChildProcess::Messages::kPassOn : ChildProcess::Messages::kKeep);
  {
    const std::stop_callback end_build(stop, [&build] { build.terminate(); });
    for (std::string line; !(line = build.readLine(kLongestSilence)).empty();)
      if (watch) tell(watch, line);
  }
  if (const int status = build.wait(); status != 0) {
    fs::remove_all(folder, failed);
    fs::remove(of_source, failed);  // only if it is empty
    throw Error(ErrorCode::kInput,
                childFailure(build, "building " + ply.string() + " failed with exit status " +
                                        std::to_string(status)));
  }
  removeOthers(of_source, folder);
  return store;
}

}  // namespace

ChildServer::ChildServer(const fs::path& store, const std::stop_token& stop)
    : token_(makeToken()),
      process_(siblingServer(),
               {"serve", store.string(), "--listen", "127.0.0.1:0", "--token-file", "/proc/self/fd/0"},
               ChildProcess::Messages::kKeep, token_ + " never *\n"),
      served_(readReadyLine(process_, store, stop)) {}

ResolvedTarget resolveTarget(const Target& target, stream::StreamOptions options, bool announce,
                             std::stop_token stop, const BuildWatch& watch) {
  if (const auto* served = std::get_if<stream::ServedModel>(&target))
    return {*served, std::move(options), nullptr, {}};
  const auto* ply = std::get_if<PlyFile>(&target);
  const fs::path file = ply ? ply->path : std::get<StoreFile>(target).path;
  const fs::path store = ply ? buildIntoCache(file, announce, stop, watch) : file;
  auto child = std::make_unique<ChildServer>(store, stop);
  options.token = child->token();
  stream::ServedModel served = child->served();
  return {std::move(served), std::move(options), std::move(child), file};
}

ModelSummary openModel(stream::Streamer& streamer, const ResolvedTarget& target,
                       std::chrono::milliseconds timeout, std::stop_token stop) {
  try {
    return streamer.waitForModel(timeout, std::move(stop));
  } catch (const Error& failed) {
    if (target.file.empty()) throw;
    throw Error(failed.code(), target.file.string() + ": " + failed.what());
  }
}

}  // namespace lode::app
