#include "client/app/window/scene/model_opener.h"

#include <utility>

#include "client/app/cli/child_server.h"
#include "client/app/cli/first_camera.h"
#include "client/app/window/panel/build_stage.h"
#include "common/start_thread.h"

namespace lode::app {
namespace {

std::string firstPhase(const Target& target) {
  if (const auto* ply = std::get_if<PlyFile>(&target)) {
    return "Building " + ply->path.filename().string() + " (kept for the next time)";
  }
  if (const auto* store = std::get_if<StoreFile>(&target))
    return "Opening " + store->path.filename().string();
  return "Connecting to " + net::toString(std::get<stream::ServedModel>(target).address);
}

}  // namespace

ModelOpener::ModelOpener(Target target, stream::StreamOptions options, core::Framing framing,
                         std::chrono::milliseconds timeout)
    : target_(std::move(target)),
      options_(std::move(options)),
      framing_(std::move(framing)),
      timeout_(timeout) {
  progress_.phase = firstPhase(target_);
  thread_ = startThread("to open a model", [this] { run(); });
}

ModelOpener::~ModelOpener() {
  stopping_.request_stop();
  {
    const std::lock_guard lock(mutex_);  // so that run() is not between looking and waiting
  }
  stop_.notify_all();
  thread_.join();
}

ModelOpener::Progress ModelOpener::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

void ModelOpener::say(std::string phase, double part) {
  const std::lock_guard lock(mutex_);
  progress_.phase = std::move(phase);
  progress_.part = part;
}

void ModelOpener::run() {
  try {
    const auto watch = [this, phase = firstPhase(target_)](std::string_view stage, double part) {
      say(phase + "\n" + describeStage(stage), part);
    };
    const ResolvedTarget resolved = resolveTarget(target_, options_, true, stopping_.get_token(), watch);
    say("Connecting to " + net::toString(resolved.served.address));
    stream::Streamer streamer(resolved.served, resolved.options);
    const ModelSummary model = openModel(streamer, resolved, timeout_, stopping_.get_token());
    const core::Framing framing = frameCoarsely(framing_, streamer, model, timeout_, stopping_.get_token());
    std::unique_lock lock(mutex_);
    progress_.phase.clear();
    progress_.streamer = &streamer;
    progress_.model = &model;
    progress_.framing = framing;
    progress_.warnings = resolved.warnings;
    stop_.wait(lock, [this] { return stopping_.stop_requested(); });
    progress_ = {};
  } catch (const Error& error) {
    const std::lock_guard lock(mutex_);
    progress_.error = error;
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    progress_.error = Error(ErrorCode::kInternal, error.what());
  }
}

}  // namespace lode::app
