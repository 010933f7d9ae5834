#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "client/app/cli/common_options.h"
#include "client/app/cli/target.h"
#include "client/core/session/session.h"
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
    lod_ = true;
    condition_.notify_one();
  }
  bool waitUntil(Clock::time_point deadline) {
    std::unique_lock lock(mutex_);
    const bool in_time = condition_.wait_until(lock, deadline, [this] { return lod_; });
    lod_ = false;
    return in_time;
  }

 private:
  std::mutex mutex_;
  std::condition_variable condition_;
  bool lod_ = false;
};

std::vector<ModelSummary> askForModels(const net::Route& route, const core::SessionOptions& session_options,
                                       std::chrono::milliseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  const std::string where = net::toString(route.address);
  Bell bell;
  core::Session session(session_options, Clock::now());
  net::TcpTransport transport(route, [&bell] { bell.ring(); });
  transport.send(session.takeOutgoing());
  while (bell.waitUntil(deadline)) {
    session.receive(transport.takeReceived(), Clock::now());
    while (auto event = session.nextEvent()) {
      if (auto* listed = std::get_if<core::ModelsListed>(&*event)) return std::move(listed->models);
      if (const auto* leaving = std::get_if<core::ServerLeaving>(&*event))
        throw Error(ErrorCode::kNetwork, leaving->reason);
    }
    transport.send(session.takeOutgoing());
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
