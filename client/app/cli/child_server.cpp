#include "client/app/cli/child_server.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "common/codec/blob.h"
#include "common/error.h"

namespace lode::app {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kReadyTimeout{60};
constexpr size_t kTokenBytes = 32;

std::string makeToken() {
  std::array<std::byte, kTokenBytes> secret;
  if (getentropy(secret.data(), secret.size()) != 0)
    throw Error(ErrorCode::kIo,
                std::string("cannot get random bytes from the system: ") + std::strerror(errno));
  return toHex(digestOf(secret));
}

stream::ServedModel readReadyLine(ChildProcess& child, const fs::path& store, const std::stop_token& stop) {
  const std::stop_callback end_child(stop, [&child] { child.terminate(); });
  const std::string line = child.readLine(kReadyTimeout);
  const auto json = nlohmann::ordered_json::parse(line, nullptr, false);
  if (line.empty() || !json.is_object() || !json.contains("listen") || !json["listen"].is_string() ||
      !json.contains("models") || !json["models"].is_array() || json["models"].size() != 1 ||
      !json["models"][0].is_string())
    throw Error(ErrorCode::kIo, saidBy(child, "lodestreamd did not get ready to serve " + store.string()));
  return {net::parseAddress(json["listen"].get<std::string>()), json["models"][0].get<std::string>()};
}

}  // namespace

ChildServer::ChildServer(const fs::path& store, const std::stop_token& stop)
    : token_(makeToken()),
      process_(siblingServer(),
               {"serve", store.string(), "--listen", "127.0.0.1:0", "--token-file", "/proc/self/fd/0"},
               ChildProcess::Messages::kKeep, {.input = token_ + " never *\n", .heeds_keys = false}),
      served_(readReadyLine(process_, store, stop)) {}

ResolvedTarget resolveTarget(const Target& target, stream::StreamOptions options, bool announce,
                             std::stop_token stop) {
  if (const auto* served = std::get_if<stream::ServedModel>(&target))
    return {*served, std::move(options), nullptr, {}, {}};
  if (const auto* store = std::get_if<StoreFile>(&target))
    return serveStore({store->path, {}}, store->path, std::move(options), stop);
  const auto& ply = std::get<PlyFile>(target);
  return serveStore(builtStore(ply, announce, stop, {}), ply.path, std::move(options), stop);
}

ResolvedTarget serveStore(BuiltStore store, const fs::path& file, stream::StreamOptions options,
                          const std::stop_token& stop) {
  auto child = std::make_unique<ChildServer>(store.path, stop);
  options.engine.session.token = child->token();
  stream::ServedModel served = child->served();
  return {std::move(served),       std::move(options),        std::move(child), file,
          std::move(store.in_use), std::move(store.warnings), store.is_preview};
}

ModelSummary openModel(stream::Streamer& streamer, const ResolvedTarget& target,
                       std::chrono::milliseconds timeout, std::stop_token stop) {
  try {
    return streamer.waitForModel(timeout, std::move(stop));
  } catch (const Error& failed) {
    if (target.file.empty()) throw;
    throw Error(failed.code(), target.file.string() + ": " + failed.what(), failed.remedy());
  }
}

}  // namespace lode::app
