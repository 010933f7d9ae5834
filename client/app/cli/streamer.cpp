#include "client/app/cli/streamer.h"

#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "client/app/cli/decode_pool.h"
#include "client/net/tcp_transport.h"
#include "common/error.h"

namespace lode::app {
namespace {

constexpr std::chrono::seconds kTick{1};  // how often a stream without events looks at the clock

using Clock = std::chrono::steady_clock;

}  // namespace

struct Streamer::State {
  State(ServedModel served_model, StreamOptions stream_options)
      : model(std::move(served_model)), options(std::move(stream_options)) {}

  void run();
  void stream();
  void stepOnce(core::Engine& engine, net::TcpTransport& transport, DecodePool& pool);
  void publish(const core::Engine& engine, uint64_t view_number);
  void end(ErrorCode code, const std::string& message);
  bool waitForWork();
  void wakeUp();
  /// Waits until `done` holds for the status of the view last set, or nothing more will come.
  template <typename Done>
  StreamStatus waitFor(std::chrono::milliseconds timeout, Done done);

  const ServedModel model;
  const StreamOptions options;

  mutable std::mutex mutex;  // of what follows
  std::condition_variable work, news;
  bool woken = true, stopping = false;
  core::View view;
  float threshold_px = 1;
  uint64_t view_number = 0;         // of the view last set; 0: none
  uint64_t status_view_number = 0;  // of the view that the status is about
  StreamStatus status;
  std::optional<ModelSummary> summary;
  std::optional<Error> error;

  std::thread thread;
};

Streamer::Streamer(ServedModel model, StreamOptions options)
    : state_(std::make_unique<State>(std::move(model), std::move(options))) {
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

Streamer::~Streamer() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
    state_->work.notify_one();
  }
  state_->thread.join();
}

void Streamer::State::run() {
  try {
    stream();
  } catch (const Error& failed) {
    end(failed.code(), failed.what());
  } catch (const std::exception& failed) {
    end(ErrorCode::kInternal, failed.what());
  }
}

void Streamer::State::stream() {
  core::EngineOptions engine_options;
  engine_options.session.model = model.model;
  engine_options.session.token = options.token;
  engine_options.memory_budget_bytes = options.memory_budget_bytes;
  engine_options.triangle_budget = options.triangle_budget;
  core::Engine engine(std::move(engine_options), Clock::now());
  net::TcpTransport transport(model.address, options.connect_timeout, [this] { wakeUp(); });
  DecodePool pool(options.decode_threads, [this] { wakeUp(); });
  while (waitForWork()) stepOnce(engine, transport, pool);
}

void Streamer::State::stepOnce(core::Engine& engine, net::TcpTransport& transport, DecodePool& pool) {
  const proto::Bytes bytes = transport.takeReceived();
  try {
    engine.receive(bytes, Clock::now());
    for (core::DecodeResult& result : pool.takeResults()) engine.finishDecode(std::move(result));
    uint64_t number = 0;
    {
      const std::lock_guard lock(mutex);
      number = view_number;
      if (number != 0) engine.setView(view, threshold_px);
    }
    engine.step(Clock::now());
    transport.send(engine.takeOutgoing());
    pool.add(engine.takeDecodeJobs());
    publish(engine, number);
  } catch (const Error& failed) {
    throw Error(failed.code(), net::toString(model.address) + ": " + failed.what());
  }
}

void Streamer::State::publish(const core::Engine& engine, uint64_t number) {
  const std::lock_guard lock(mutex);
  if (!summary && engine.summary()) summary = *engine.summary();
  if (status.cut != engine.cut()) {
    status.cut = engine.cut();
    status.cut_blob_bytes = engine.cutBlobBytes();
  }
  status.counts = engine.counts();
  status.limited = engine.limited();
  status.settled = engine.settled();
  status.failure = engine.failure();
  status_view_number = number;
  news.notify_all();
}

void Streamer::State::end(ErrorCode code, const std::string& message) {
  const std::lock_guard lock(mutex);
  error.emplace(code, message);
  status.failure = message;
  status.ended = true;
  news.notify_all();
}

bool Streamer::State::waitForWork() {
  std::unique_lock lock(mutex);
  work.wait_for(lock, kTick, [this] { return woken || stopping; });
  woken = false;
  return !stopping;
}

void Streamer::State::wakeUp() {
  const std::lock_guard lock(mutex);
  woken = true;
  work.notify_one();
}

template <typename Done>
StreamStatus Streamer::State::waitFor(std::chrono::milliseconds timeout, Done done) {
  std::unique_lock lock(mutex);
  news.wait_for(lock, timeout, [&] {
    return status.ended || (status_view_number == view_number && (done(status) || !status.failure.empty()));
  });
  StreamStatus result = status;
  if (status_view_number != view_number) result.settled = result.limited = false;
  return result;
}

const ModelSummary& Streamer::waitForModel(std::chrono::milliseconds timeout) {
  std::unique_lock lock(state_->mutex);
  state_->news.wait_for(lock, timeout, [this] { return state_->summary || state_->error; });
  if (state_->summary) return *state_->summary;
  if (state_->error) throw *state_->error;
  throw Error(ErrorCode::kTimeout, "no answer from " + net::toString(state_->model.address) + " within " +
                                       std::to_string(timeout.count()) +
                                       " ms: check the server, or allow more time");
}

void Streamer::setView(const core::View& view, float threshold_px) {
  const std::lock_guard lock(state_->mutex);
  if (state_->view_number != 0 && state_->view == view && state_->threshold_px == threshold_px) return;
  state_->view = view;
  state_->threshold_px = threshold_px;
  ++state_->view_number;
  state_->woken = true;
  state_->work.notify_one();
}

StreamStatus Streamer::status() const {
  const std::lock_guard lock(state_->mutex);
  return state_->status;
}

StreamStatus Streamer::waitForConvergence(std::chrono::milliseconds timeout) {
  return state_->waitFor(timeout, [](const StreamStatus& status) { return status.settled; });
}

StreamStatus Streamer::waitForCut(std::chrono::milliseconds timeout) {
  return state_->waitFor(timeout, [](const StreamStatus& status) { return status.cut != nullptr; });
}

}  // namespace lode::app
