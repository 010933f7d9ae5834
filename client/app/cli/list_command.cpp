#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "client/app/cli/common_options.h"
#include "client/app/cli/target.h"
#include "client/core/session/session.h"
#include "client/net/exchange.h"
#include "client/net/tcp_transport.h"
#include "common/error.h"

namespace lode::app {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

struct ListOptions {
  CommonOptions common;
  bool json = false;
};

/// Lets one thread wait until a transport has received bytes.
class Bell {
 public:
  void ring() {
    const std::lock_guard lock(mutex_);
    rung_ = true;
    condition_.notify_one();
  }
  bool waitUntil(Clock::time_point deadline) {
    std::unique_lock lock(mutex_);
    condition_.wait_until(lock, deadline, [this] { return rung_; });
    rung_ = false;
    // Check the deadline, because a server that floods the client with frames would ring forever.
    return Clock::now() < deadline;
  }

 private:
  std::mutex mutex_;
  std::condition_variable condition_;
  bool rung_ = false;
};

/// The client's end of a session that asks for the list of models; used with net::exchange().
class ListEnd {
 public:
  explicit ListEnd(const core::SessionOptions& options) : session_(options, Clock::now()) {}

  bool connected() const noexcept { return !models_; }
  bool takesInput() const noexcept { return session_.takesInput(); }
  proto::Bytes takeOutgoing() { return session_.takeOutgoing(); }
  void receive(std::span<const std::byte> bytes) {
    session_.receive(bytes, Clock::now());
    while (auto event = session_.nextEvent()) {
      if (auto* listed = std::get_if<core::ModelsListed>(&*event)) models_ = std::move(listed->models);
      if (const auto* leaving = std::get_if<core::ServerLeaving>(&*event))
        throw Error(ErrorCode::kNetwork, leaving->reason, leaving->remedy);
    }
  }
  /// Returns the models, or nothing until the server has listed them.
  std::optional<std::vector<ModelSummary>>& models() noexcept { return models_; }

 private:
  core::Session session_;
  std::optional<std::vector<ModelSummary>> models_;
};

std::vector<ModelSummary> askForModels(const net::Route& route, const core::SessionOptions& session_options,
                                       std::chrono::milliseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  const std::string where = net::toString(route.address);
  Bell bell;
  ListEnd end(session_options);
  net::TcpTransport transport(route, [&bell] { bell.ring(); });
  bell.ring();
  while (bell.waitUntil(deadline)) {
    if (net::exchange(transport, end)) bell.ring();
    if (end.models()) return std::move(*end.models());
    net::sendOutgoing(transport, end);
  }
  throw Error(ErrorCode::kTimeout, "no list from " + where + " within " + std::to_string(timeout.count()) +
                                       " ms: check the server, or allow more time");
}

Json toJson(const ModelSummary& model) {
  Json json;
  json["name"] = model.name;
  json["build_id"] = toHex(model.build_id);
  json["triangles"] = model.triangles;
  json["nodes"] = model.nodes;
  json["bytes"] = model.bytes;
  json["depth"] = model.depth;
  return json;
}

void list(const ListOptions& options) {
  const stream::ServedModel server = parseServerUrl(options.common.target);
  const stream::StreamOptions stream_options = options.common.streamOptions();
  std::vector<ModelSummary> models;
  try {
    models = askForModels(stream::routeTo(server, stream_options), stream_options.engine.session,
                          options.common.timeout());
  } catch (const Error& failed) {
    throw net::naming(server.address, failed);
  }
  if (options.json) {
    Json json;
    json["models"] = Json::array();
    for (const ModelSummary& model : models) json["models"].push_back(toJson(model));
    std::printf("%s\n", json.dump().c_str());
    return;
  }
  for (const ModelSummary& model : models)
    std::printf("%-32s %12llu triangles %14llu bytes\n", model.name.c_str(),
                static_cast<unsigned long long>(model.triangles),
                static_cast<unsigned long long>(model.bytes));
}

}  // namespace

void declareList(CLI::App& program, int& /*exit_status*/) {
  CLI::App* command = program.add_subcommand("list", "Lists the models of a server");
  const auto options = std::make_shared<ListOptions>();
  addServerOptions(*command, options->common, "lode://HOST[:PORT] or lodes://HOST[:PORT]");
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options] { list(*options); });
}

}  // namespace lode::app
