#include "client/stream/streamer.h"

#include <algorithm>
#include <array>
#include <condition_variable>
#include <iterator>
#include <mutex>
#include <new>
#include <random>
#include <string_view>
#include <thread>
#include <utility>

#include "client/net/exchange.h"
#include "client/net/tcp_transport.h"
#include "client/stream/cache_thread.h"
#include "client/stream/decode_pool.h"
#include "client/stream/published_cuts.h"
#include "common/error.h"
#include "common/start_thread.h"

namespace lode::stream {
namespace {

constexpr std::chrono::seconds kTick{1};  // longest interval between two steps of the stream's thread
constexpr std::chrono::milliseconds kRetryTick{50};  // longest interval between two steps while the stream
                                                     // waits to reconnect

using Clock = std::chrono::steady_clock;

/// Transports of the active and the draining session, indexed by core::SessionRole.
using Transports = std::array<std::unique_ptr<net::TcpTransport>, 2>;

/// Returns true if the status has changed, apart from its counts.
bool isNews(const StreamStatus& now, const StreamStatus& last) {
  return now.cut != last.cut || now.limited != last.limited || now.settled != last.settled ||
         now.exhausted != last.exhausted || now.failure != last.failure || now.trouble != last.trouble;
}

std::unique_ptr<net::TcpTransport>& transportOf(Transports& transports, core::SessionRole role) {
  return transports[static_cast<size_t>(role)];
}

/// Passes received bytes to the engine. Closes the transport if the engine no longer needs it.
/// @return true if more bytes may wait.
bool receiveFrom(std::unique_ptr<net::TcpTransport>& transport, core::SessionRole role,
                 core::Engine& engine) {
  if (!transport) return false;
  bool more = false;
  try {
    net::EngineEnd end(engine, role, Clock::now());
    more = net::exchange(*transport, end);
  } catch (const Error& failed) {
    engine.disconnect(failed, Clock::now(), role);
  }
  if (!engine.connected(role)) transport.reset();
  return more;
}

}  // namespace

struct Streamer::State {
  State(ServedModel served_model, StreamOptions stream_options)
      : model(std::move(served_model)),
        options(std::move(stream_options)),
        memory_budget_bytes(options.engine.memory_budget_bytes),
        drawn_budget_bytes(options.engine.refine.drawn_budget_bytes),
        starting_pool(std::make_unique<DecodePool>(options.decode_threads, [this] { wakeUp(); })) {}

  void run();
  void stream();
  void keepConnected(core::Engine& engine, const net::Route& route, Transports& transports);
  std::unique_ptr<CacheThread> openCache(core::EngineOptions& engine_options);
  void askCache(core::Engine& engine, CacheThread& cache);
  void stepOnce(core::Engine& engine, Transports& transports, DecodePool& pool, CacheThread* cache);
  void publish(const core::Engine& engine, uint64_t view_number);
  void end(const Error& why);
  void notifyOfSameViews();
  bool waitForWork(std::chrono::milliseconds longest);
  void wakeUp();
  StreamStatus statusOfView() const;
  /// Waits until `done` is true for the status of the view that was set last, or the stream is exhausted or
  /// has ended.
  template <typename Done>
  StreamStatus waitFor(std::chrono::milliseconds timeout, Done done);

  const ServedModel model;
  const StreamOptions options;

  mutable std::mutex mutex;  // guards the members below
  std::condition_variable work;
  std::condition_variable_any news;
  bool woken = true, stopping = false;
  std::vector<core::View> views;
  float threshold_px = 1;
  uint64_t memory_budget_bytes, drawn_budget_bytes;
  uint64_t view_number = 0;         // serial number of the view that was set last; 0: none
  uint64_t status_view_number = 0;  // serial number of the view that the status describes
  std::vector<std::shared_ptr<const core::Cut>> to_keep;
  StreamStatus status;
  bool has_news = false;  // true if waitForNews() has not reported the last change yet
  std::optional<ModelSummary> summary;
  std::optional<Error> error;

  // Only the stream's thread uses these members:
  Digest kept_build_id;  // build of the cached summary
  PublishedCuts published;
  // Pool for stream(). The constructor creates it, so that it can report errors.
  std::unique_ptr<DecodePool> starting_pool;
  std::thread thread;
};

net::Route routeTo(const ServedModel& model, const StreamOptions& options) {
  return {model.address, options.connect_timeout,
          model.encrypted ? net::trustAuthorities(options.ca_file) : nullptr};
}

Streamer::Streamer(ServedModel model, StreamOptions options)
    : state_(std::make_unique<State>(std::move(model), std::move(options))) {
  state_->thread = startThread("for a stream", [state = state_.get()] { state->run(); });
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
    end(failed);
  } catch (const std::bad_alloc&) {
    end(Error(ErrorCode::kIo, kOutOfMemory));
  } catch (const std::exception& failed) {
    end(Error(ErrorCode::kInternal, failed.what()));
  }
}

void Streamer::State::stream() {
  core::EngineOptions engine_options = options.engine;
  engine_options.session.model = model.model;
  engine_options.jitter_seed = std::random_device()();
  std::unique_ptr<CacheThread> cache = openCache(engine_options);
  core::Engine engine(std::move(engine_options));
  const net::Route route = routeTo(model, options);
  Transports transports;
  const std::unique_ptr<DecodePool> pool = std::move(starting_pool);
  while (waitForWork(engine.staysConnected() ? kTick : kRetryTick)) {
    try {
      keepConnected(engine, route, transports);
      if (cache) askCache(engine, *cache);
      stepOnce(engine, transports, *pool, cache.get());
    } catch (const Error& failed) {
      throw net::naming(model.address, failed);
    }
  }
}

/// Opens the cache. Returns null if there is no cache folder. @throws Error if the stream is offline and the
/// cache lacks the model.
std::unique_ptr<CacheThread> Streamer::State::openCache(core::EngineOptions& engine_options) {
  if (options.cache_folder.empty()) return nullptr;
  const BlobCache cache(options.cache_folder, options.cache_bytes);
  engine_options.has_cache = true;
  engine_options.cached_model = cache.summary(model);
  if (options.engine.offline && !engine_options.cached_model)
    throw Error(ErrorCode::kInput, toString(model) + " is not in the cache " + options.cache_folder.string() +
                                       ": run once without --offline");
  return std::make_unique<CacheThread>(cache, [this] { wakeUp(); });
}

/// Exchanges blobs between the engine and the cache.
void Streamer::State::askCache(core::Engine& engine, CacheThread& cache) {
  for (CacheThread::Answer& answer : cache.takeAnswers())
    engine.finishCacheQuery(answer.blob, std::move(answer.bytes));
  if (const ModelSummary* opened = engine.summary();
      opened && opened->build_id != kept_build_id && !options.engine.offline) {
    kept_build_id = opened->build_id;
    BlobCache(options.cache_folder, options.cache_bytes).keepSummary(model, *opened);
  }
  for (core::Engine::Arrival& arrival : engine.takeArrivals())
    cache.keep(arrival.blob, std::move(arrival.bytes));
}

/// Opens a transport if the engine needs one, and passes the received bytes of all transports to the engine.
void Streamer::State::keepConnected(core::Engine& engine, const net::Route& route, Transports& transports) {
  auto& [newest, leaving] = transports;
  if (engine.wantsConnection(Clock::now())) {
    if (newest) leaving = std::move(newest);
    newest = std::make_unique<net::TcpTransport>(route, [this] { wakeUp(); });
    engine.connect(Clock::now());
  }
  for (const core::SessionRole role : core::kSessionRoles)
    if (receiveFrom(transportOf(transports, role), role, engine)) wakeUp();
}

void Streamer::State::stepOnce(core::Engine& engine, Transports& transports, DecodePool& pool,
                               CacheThread* cache) {
  for (core::DecodeResult& result : pool.takeResults()) engine.finishDecode(std::move(result));
  uint64_t number = 0;
  {
    const std::lock_guard lock(mutex);
    number = view_number;
    engine.setMemoryBudget(memory_budget_bytes, drawn_budget_bytes);
    if (number != 0) engine.setViews(views, threshold_px);
    for (const auto& cut : std::exchange(to_keep, {})) published.add(cut, nullptr);
  }
  engine.step(Clock::now());
  for (const core::SessionRole role : core::kSessionRoles) {
    net::EngineEnd end(engine, role, Clock::now());
    if (const auto& transport = transportOf(transports, role)) net::sendOutgoing(*transport, end);
  }
  pool.add(engine.takeDecodeJobs());
  if (cache) cache->find(engine.takeCacheQueries());
  publish(engine, number);
  published.releaseStorage();
}

void Streamer::State::publish(const core::Engine& engine, uint64_t number) {
  StreamStatus now;
  now.cut = engine.cut();
  now.view_cuts = engine.viewCuts();
  now.cut_build = engine.cutBuild();
  now.counts = engine.counts();
  now.limited = engine.limited();
  now.settled = engine.settled();
  now.failure = engine.failure();
  now.failure_may_pass = engine.failureMayPass();
  now.trouble = engine.trouble();
  now.trouble_remedy = engine.troubleRemedy();
  now.exhausted = number != 0 && engine.exhausted() && !now.settled;
  if (now.exhausted && now.failure.empty())
    now.failure = "the cache lacks parts that the view needs: run without --offline";
  published.add(now.cut, now.view_cuts);
  const std::lock_guard lock(mutex);
  const bool is_new_build = engine.summary() && (!summary || summary->build_id != engine.summary()->build_id);
  has_news |= is_new_build || status_view_number != number || isNews(now, status);
  if (is_new_build) summary = *engine.summary();
  std::swap(status, now);  // moves the old status to `now`, so that it is freed after the lock is released
  status_view_number = number;
  news.notify_all();
}

void Streamer::State::end(const Error& why) {
  const std::lock_guard lock(mutex);
  error = why;
  status.failure = why.what();
  status.failure_remedy = why.remedy();
  status.failure_may_pass = false;
  status.trouble.clear();
  status.trouble_remedy = Remedy::kNone;
  status.ended = has_news = true;
  news.notify_all();
}

/// Wakes waitForNews() if the same views are set again and the status is final. Requires the lock.
void Streamer::State::notifyOfSameViews() {
  if (status_view_number != view_number || (!status.settled && !status.exhausted && !status.ended)) return;
  has_news = true;
  news.notify_all();
}

bool Streamer::State::waitForWork(std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex);
  work.wait_for(lock, longest, [this] { return woken || stopping; });
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
    return status.ended || (status_view_number == view_number && (done(status) || status.exhausted));
  });
  return statusOfView();
}

/// Returns the status. Clears flags that refer to an outdated view.
StreamStatus Streamer::State::statusOfView() const {
  StreamStatus result = status;
  result.current = status_view_number == view_number;
  if (!result.current) result.settled = result.limited = false;
  return result;
}

ModelSummary Streamer::waitForModel(std::chrono::milliseconds timeout, std::stop_token stop) {
  std::unique_lock lock(state_->mutex);
  state_->news.wait_for(lock, std::move(stop), timeout, [this] { return state_->summary || state_->error; });
  if (state_->summary) return *state_->summary;
  if (state_->error) throw *state_->error;
  throw Error(ErrorCode::kTimeout,
              "no answer from " + net::toString(state_->model.address) + " within " +
                  std::to_string(timeout.count()) + " ms" +
                  (state_->status.trouble.empty() ? ": check the server, or allow more time"
                                                  : ": " + state_->status.trouble),
              state_->status.trouble_remedy);
}

void Streamer::setViews(std::span<const core::View> views, float threshold_px) {
  const std::lock_guard lock(state_->mutex);
  if (state_->view_number != 0 && std::ranges::equal(state_->views, views) &&
      state_->threshold_px == threshold_px) {
    state_->notifyOfSameViews();
    return;
  }
  state_->views.assign(views.begin(), views.end());
  state_->threshold_px = threshold_px;
  ++state_->view_number;
  state_->woken = true;
  state_->work.notify_one();
}

void Streamer::setMemoryBudget(uint64_t bytes, uint64_t drawn_bytes) {
  const std::lock_guard lock(state_->mutex);
  state_->memory_budget_bytes = bytes;
  state_->drawn_budget_bytes = drawn_bytes;
  state_->woken = true;
  state_->work.notify_one();
}

void Streamer::keep(std::vector<std::shared_ptr<const core::Cut>> cuts) {
  const std::lock_guard lock(state_->mutex);
  if (state_->status.ended) return;  // keeps nothing, because the thread that frees cuts has ended
  std::ranges::move(cuts, std::back_inserter(state_->to_keep));
}

StreamStatus Streamer::status() const {
  const std::lock_guard lock(state_->mutex);
  StreamStatus result = state_->statusOfView();
  result.limited = state_->status.limited;  // needed while the camera moves, to divide a scene's memory
  return result;
}

std::optional<ModelSummary> Streamer::model() const {
  const std::lock_guard lock(state_->mutex);
  return state_->summary;
}

StreamStatus Streamer::waitForNews(std::chrono::milliseconds timeout) {
  std::unique_lock lock(state_->mutex);
  state_->news.wait_for(lock, timeout, [this] { return state_->has_news; });
  state_->has_news = state_->status.ended;
  return state_->statusOfView();
}

StreamStatus Streamer::waitForConvergence(std::chrono::milliseconds timeout) {
  return state_->waitFor(timeout, [](const StreamStatus& status) {
    return status.settled || (status.cut && status.cut->converged);
  });
}

StreamStatus Streamer::waitUntilSettled(std::chrono::milliseconds timeout) {
  return state_->waitFor(timeout, [](const StreamStatus& status) { return status.settled; });
}

StreamStatus Streamer::waitForCut(std::chrono::milliseconds timeout) {
  return state_->waitFor(timeout, [](const StreamStatus& status) { return status.cut || status.settled; });
}

}  // namespace lode::stream
