#include "client/app/window/scene/model_opener.h"

#include <utility>
#include <variant>

#include "client/app/cli/build_step.h"
#include "client/app/cli/child_server.h"
#include "client/app/cli/opened_target.h"
#include "common/start_thread.h"

namespace lode::app {
namespace {

constexpr std::chrono::seconds kBetweenAttempts{5};

bool isUnreachable(const Error& error) {
  return error.code() == ErrorCode::kNetwork || error.code() == ErrorCode::kTimeout;
}

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
    const std::lock_guard lock(mutex_);  // without this lock, run() could miss the notification
  }
  stop_.notify_all();
  thread_.join();
}

ModelOpener::Progress ModelOpener::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

void ModelOpener::report(std::string phase, double part) {
  const std::lock_guard lock(mutex_);
  progress_.phase = std::move(phase);
  progress_.part = part;
}

void ModelOpener::run() {
  try {
    const auto watch = [this, phase = firstPhase(target_)](const BuildStep& step) {
      report(phase + "\n" + stepInWords(step), step.fraction);
    };
    const ResolvedTarget resolved = resolveTarget(target_, options_, true, stopping_.get_token(), watch);
    report("Connecting to " + net::toString(resolved.served.address));
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

RetryingOpener::RetryingOpener(std::string target, std::filesystem::path textures_folder,
                               stream::StreamOptions options, core::Framing framing,
                               std::chrono::milliseconds timeout)
    : target_(std::move(target)),
      textures_folder_(std::move(textures_folder)),
      options_(std::move(options)),
      framing_(std::move(framing)),
      timeout_(timeout) {
  begin();
}

void RetryingOpener::begin() {
  next_attempt_.reset();
  try {
    Target target = parseTarget(target_, textures_folder_);
    target_is_server_ = std::holds_alternative<stream::ServedModel>(target);
    opener_.emplace(std::move(target), options_, framing_, timeout_);
  } catch (const Error& error) {
    fail(error);
  }
}

void RetryingOpener::fail(const Error& error) {
  opener_.reset();
  progress_.error = error;
  if (isUnreachable(error)) next_attempt_ = Clock::now() + kBetweenAttempts;
}

const ModelOpener::Progress& RetryingOpener::poll() {
  if (progress_.streamer != nullptr) return progress_;
  if (next_attempt_ && Clock::now() >= *next_attempt_) begin();
  if (!opener_) return progress_;
  ModelOpener::Progress now = opener_->progress();
  if (now.error) {
    fail(*now.error);
  } else {
    if (now.streamer == nullptr) now.error = std::move(progress_.error);
    progress_ = std::move(now);
  }
  return progress_;
}

}  // namespace lode::app
