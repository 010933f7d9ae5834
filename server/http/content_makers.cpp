#include "server/http/content_makers.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include <sys/resource.h>
#include <unistd.h>

#include "common/error.h"
#include "common/start_thread.h"

namespace lode::http {

namespace {

constexpr std::chrono::seconds kJoinPatience(1);
/// Lowers the threads' priority, so that they do not delay the threads that send.
constexpr int kNice = 10;
/// Largest number of requests that wait for the same content; further requests are refused.
constexpr size_t kMostWaiting = 4096;

}  // namespace

struct ContentMakers::State {
  explicit State(const ContentMakersOptions& given) : options(given), cache(given.memory_bytes) {}

  struct Job {
    Make make;
    std::vector<Done> waiting;
  };

  void run();
  void makeNext(std::unique_lock<std::mutex>& lock);

  const ContentMakersOptions options;
  ContentCache cache;
  std::atomic<uint64_t> made{0};
  std::mutex mutex;  ///< guards all members below
  std::condition_variable has_work, has_ended;
  std::unordered_map<std::string, Job> jobs;  ///< waiting and running
  std::deque<std::string> queue;              ///< keys of waiting jobs
  unsigned running_threads = 0;
  bool stopped = false;
};

void ContentMakers::State::run() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  std::unique_lock lock(mutex);
  while (true) {
    has_work.wait(lock, [this] { return stopped || !queue.empty(); });
    if (stopped) break;
    makeNext(lock);
  }
  --running_threads;
  has_ended.notify_all();
}

/// Makes the content of the first job. The lock is released while the content is made.
void ContentMakers::State::makeNext(std::unique_lock<std::mutex>& lock) {
  const std::string key = std::move(queue.front());
  queue.pop_front();
  const Make make = std::move(jobs.at(key).make);
  lock.unlock();
  MakeResult result = MakeResult::kFailed;
  std::shared_ptr<const Content> content;
  try {
    content = cache.find(key);  // another thread may have made the content since the request
    if (!content) {
      content = cache.add(key, make());
      made.fetch_add(1, std::memory_order_relaxed);
    }
    result = content ? MakeResult::kDone : MakeResult::kBusy;
  } catch (const Error& error) {  // `make` has reported the error
    result = error.code() == ErrorCode::kIo ? MakeResult::kUnreadable : MakeResult::kFailed;
  } catch (const std::bad_alloc&) {
    result = MakeResult::kBusy;
  } catch (const std::exception&) {
  }
  lock.lock();
  const auto job = jobs.find(key);
  if (job == jobs.end()) return;  // join() has dropped the job
  // Keeps the mutex locked, so that no `done` is called after join().
  for (const Done& done : job->second.waiting) try {
      done(result, content);
    } catch (const std::exception&) {  // memory ran out; the connection's deadline ends the wait
    }
  jobs.erase(job);
}

ContentMakers::ContentMakers(ContentMakersOptions options) : state_(std::make_shared<State>(options)) {
  for (unsigned i = 0; i < std::max(1u, options.threads); ++i) {
    {
      const std::lock_guard lock(state_->mutex);
      ++state_->running_threads;
    }
    try {
      startThread<std::thread>("to make tiles", [state = state_] { state->run(); }).detach();
    } catch (const std::exception&) {
      const std::lock_guard lock(state_->mutex);
      --state_->running_threads;
      if (state_->running_threads == 0) throw;
    }
  }
}

ContentMakers::~ContentMakers() { join(); }

std::shared_ptr<const Content> ContentMakers::find(const std::string& key) { return state_->cache.find(key); }

bool ContentMakers::make(const std::string& key, Make make, Done done) {
  const std::lock_guard lock(state_->mutex);
  if (state_->stopped) return false;
  if (const auto job = state_->jobs.find(key); job != state_->jobs.end()) {
    if (job->second.waiting.size() >= kMostWaiting) return false;
    job->second.waiting.push_back(std::move(done));
    return true;
  }
  if (state_->queue.size() >= state_->options.queue) return false;
  State::Job& job = state_->jobs[key];
  try {
    job.make = std::move(make);
    job.waiting.push_back(std::move(done));
    state_->queue.push_back(key);
  } catch (...) {
    state_->jobs.erase(key);
    throw;
  }
  state_->has_work.notify_one();
  return true;
}

ContentCache& ContentMakers::cache() noexcept { return state_->cache; }

uint64_t ContentMakers::made() const noexcept { return state_->made.load(std::memory_order_relaxed); }

void ContentMakers::join() {
  std::unordered_map<std::string, State::Job> dropped;
  std::unique_lock lock(state_->mutex);
  state_->stopped = true;
  dropped.swap(state_->jobs);
  state_->queue.clear();
  state_->has_work.notify_all();
  state_->has_ended.wait_for(lock, kJoinPatience, [this] { return state_->running_threads == 0; });
}

}  // namespace lode::http
