#include "client/app/window/scene/model_opener.h"

#include <deque>
#include <utility>
#include <variant>

#include "client/app/cli/build_step.h"
#include "client/app/cli/child_server.h"
#include "client/app/cli/opened_target.h"
#include "common/start_thread.h"

namespace lode::app {
namespace {

constexpr std::chrono::seconds kBetweenAttempts{5};
constexpr std::chrono::milliseconds kLookAgain{20};

bool isUnreachable(const Error& error) {
  return error.code() == ErrorCode::kNetwork || error.code() == ErrorCode::kTimeout;
}

std::string firstPhase(const Target& target) {
  if (const auto* ply = std::get_if<PlyFile>(&target)) {
    return isCopyOfInput(ply->path)
               ? "Building the model from standard input"
               : "Building " + ply->path.filename().string() + " (kept for the next time)";
  }
  if (const auto* store = std::get_if<StoreFile>(&target))
    return "Opening " + store->path.filename().string();
  return "Connecting to " + net::toString(std::get<stream::ServedModel>(target).address);
}

}  // namespace

ModelOpener::ModelOpener(Target target, stream::StreamOptions options, core::Framing framing,
                         std::chrono::milliseconds timeout, bool previews)
    : target_(std::move(target)),
      options_(std::move(options)),
      framing_(std::move(framing)),
      timeout_(timeout),
      previews_(previews) {
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

/// A target with its stream, the summary of its preview and the summary of its store.
struct ModelOpener::Opened {
  ResolvedTarget target;
  stream::Streamer streamer;
  std::deque<ModelSummary> summaries;

  explicit Opened(ResolvedTarget resolved)
      : target(std::move(resolved)), streamer(target.served, target.options) {}
};

void ModelOpener::run() {
  std::optional<Opened> opened;
  try {
    openTarget(opened);
  } catch (const Error& error) {
    fail(error);
  } catch (const std::exception& error) {
    fail(Error(ErrorCode::kInternal, error.what()));
  }
  std::unique_lock lock(mutex_);
  if (progress_.streamer == nullptr) return;
  stop_.wait(lock, [this] { return stopping_.stop_requested(); });
  progress_ = {};
}

/// Reports that the target cannot be opened. If a preview is shown, keeps it and adds a warning.
void ModelOpener::fail(const Error& error) {
  const std::lock_guard lock(mutex_);
  if (progress_.streamer == nullptr) {
    progress_.error = error;
    return;
  }
  progress_.phase.clear();
  progress_.warnings = {std::string("only a preview is shown: ") + error.what()};
}

void ModelOpener::openTarget(std::optional<Opened>& opened) {
  if (const auto* ply = std::get_if<PlyFile>(&target_)) return buildAndOpen(*ply, opened);
  opened.emplace(resolveTarget(target_, options_, true, stopping_.get_token()));
  show(*opened, false);
}

void ModelOpener::buildAndOpen(const PlyFile& ply, std::optional<Opened>& opened) {
  const std::string phase = firstPhase(target_);
  BuildWatch watch;
  watch.on_step = [&](const BuildStep& step) { report(phase + "\n" + stepInWords(step), step.fraction); };
  if (previews_)
    watch.on_preview = [&](const std::filesystem::path& preview) {
      try {
        opened.emplace(serveStore({preview, {}}, ply.path, options_, stopping_.get_token()));
        show(*opened, true);
      } catch (const Error&) {  // without a preview, the window shows the store later
        opened.reset();
        if (stopping_.stop_requested()) throw;
      }
    };
  BuiltStore store = builtStore(ply, true, stopping_.get_token(), watch);
  if (opened) return replacePreview(*opened, std::move(store));
  opened.emplace(serveStore(std::move(store), ply.path, options_, stopping_.get_token()));
  show(*opened, false);
}

/// Waits until the model is open, and publishes it in the progress.
void ModelOpener::show(Opened& opened, bool is_preview) {
  if (!is_preview) report("Connecting to " + net::toString(opened.target.served.address));
  const ModelSummary& model = opened.summaries.emplace_back(
      openModel(opened.streamer, opened.target, timeout_, stopping_.get_token()));
  const core::Framing framing =
      frameCoarsely(framing_, opened.streamer, model, timeout_, stopping_.get_token());
  const std::lock_guard lock(mutex_);
  if (!is_preview) progress_.phase.clear();
  progress_.streamer = &opened.streamer;
  progress_.model = &model;
  progress_.is_preview = is_preview;
  progress_.framing = framing;
  progress_.warnings = opened.target.warnings;
}

/// Makes the preview's server serve the store under the same name. Clients switch to the store, and show the
/// preview meanwhile.
void ModelOpener::replacePreview(Opened& opened, BuiltStore store) {
  const std::filesystem::path served = previewBeside(store.path);
  const std::filesystem::path link = served.parent_path() / "store";
  std::error_code failed, ignored;
  std::filesystem::remove(link, ignored);
  std::filesystem::create_symlink(store.path, link, failed);
  if (!failed) std::filesystem::rename(link, served, failed);
  std::optional<ModelSummary> model;
  if (!failed) {
    opened.target.child->reload();
    model = waitForStore(opened);
  }
  std::filesystem::remove_all(served.parent_path(), ignored);
  if (stopping_.stop_requested()) return;
  if (!model)
    throw Error(ErrorCode::kIo, store.path.string() + " is built, but cannot be shown; open the file again");
  opened.target.in_use = std::move(store.in_use);
  const std::lock_guard lock(mutex_);
  progress_.phase.clear();
  progress_.part = -1;
  progress_.model = &opened.summaries.emplace_back(std::move(*model));
  progress_.is_preview = false;
  progress_.warnings = std::move(store.warnings);
}

/// Waits until the stream of a preview has opened the store. @return nothing if the stream ends, the time is
/// over or a stop is requested.
std::optional<ModelSummary> ModelOpener::waitForStore(Opened& opened) {
  const Digest preview = opened.summaries.back().build_id;
  const auto deadline = std::chrono::steady_clock::now() + timeout_;
  while (!stopping_.stop_requested() && std::chrono::steady_clock::now() < deadline) {
    std::optional<ModelSummary> model = opened.streamer.model();
    if (model && model->build_id != preview) return model;
    if (opened.streamer.waitForNews(kLookAgain).ended) return std::nullopt;
  }
  return std::nullopt;
}

RetryingOpener::RetryingOpener(std::string target, std::filesystem::path textures_folder,
                               stream::StreamOptions options, core::Framing framing,
                               std::chrono::milliseconds timeout, bool previews)
    : target_(std::move(target)),
      textures_folder_(std::move(textures_folder)),
      options_(std::move(options)),
      framing_(std::move(framing)),
      timeout_(timeout),
      previews_(previews) {
  begin();
}

void RetryingOpener::begin() {
  next_attempt_.reset();
  try {
    Target target = parseTarget(target_, textures_folder_);
    target_is_server_ = std::holds_alternative<stream::ServedModel>(target);
    opener_.emplace(std::move(target), options_, framing_, timeout_, previews_);
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
  if (progress_.streamer != nullptr && !progress_.is_preview) return progress_;
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
