#include "client/loadtest/load_test.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <queue>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <sys/resource.h>

#include "client/loadtest/full_client.h"
#include "client/loadtest/trace_client.h"
#include "common/error.h"

namespace lode::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLongestWait = std::chrono::milliseconds(100);
constexpr auto kPublishEvery = std::chrono::milliseconds(200);
/// Longest time for which network events are handled before due clients are stepped.
constexpr auto kLongestBurst = std::chrono::milliseconds(10);
/// Number of descriptors that the process needs in addition to its connections.
constexpr rlim_t kOtherDescriptors = 64;

void allowDescriptors(uint32_t clients) {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
  if (clients + kOtherDescriptors > limit.rlim_cur)
    throw Error(ErrorCode::kUsage, std::to_string(clients) + " clients need more open files than the " +
                                       std::to_string(limit.rlim_cur) +
                                       " that the system allows: raise ulimit -n, or give fewer --clients");
}

/// A thread's share of the clients, and the loop that steps them.
class Stepper {
 public:
  void addFull(const LoadPlan& plan, Clock::time_point start, uint64_t seed) {
    add(std::make_unique<FullClient>(io_, plan, start, seed, names_, counts_), start);
  }
  void addTrace(const LoadPlan& plan, Clock::time_point start, double phase_s) {
    add(std::make_unique<TraceClient>(io_, plan, start, phase_s, names_, counts_), start);
  }

  void run(Clock::time_point end, const std::function<bool()>& is_stopped) {
    Clock::time_point publish_at{};
    for (Clock::time_point now = Clock::now(); now < end; now = Clock::now()) {
      if (is_stopped && is_stopped()) {
        end = now;
        break;
      }
      if (now >= publish_at) {
        publish();
        publish_at = now + kPublishEvery;
      }
      const Clock::time_point next = due_.empty() ? end : std::min(due_.top().first, end);
      if (next > now) io_.run_one_until(std::min(next, now + kLongestWait));
      const Clock::time_point burst_end = Clock::now() + kLongestBurst;
      while (io_.poll_one() > 0 && Clock::now() < burst_end) continue;
      io_.restart();
      stepDue(std::min(Clock::now(), end));
    }
    for (const auto& client : clients_) client->finish(end);
    clients_.clear();
    publish();
  }

  /// Returns the counters of the clients as last published. Thread safe.
  LoadCounts counts() const {
    const std::lock_guard lock(mutex_);
    return published_;
  }

 private:
  void add(std::unique_ptr<LoadClient> client, Clock::time_point start) {
    clients_.push_back(std::move(client));
    due_.push({start, clients_.size() - 1});
  }

  void publish() {
    const std::lock_guard lock(mutex_);
    published_ = counts_;
  }

  /// Steps all clients that are due. @param now  not later than the end of the test.
  void stepDue(Clock::time_point now) {
    while (!due_.empty() && due_.top().first <= now) {
      const size_t client = due_.top().second;
      due_.pop();
      clients_[client]->step(now);
      if (clients_[client]->due() != kNever) due_.push({clients_[client]->due(), client});
    }
  }

  KnownDigests names_;
  LoadCounts counts_;
  mutable std::mutex mutex_;
  LoadCounts published_;
  asio::io_context io_{1};
  /// Makes run_one_until() wait even while no connection exists. Otherwise it would return at once.
  const asio::executor_work_guard<asio::io_context::executor_type> waits_{io_.get_executor()};
  std::vector<std::unique_ptr<LoadClient>> clients_;
  using Due = std::pair<Clock::time_point, size_t>;
  std::priority_queue<Due, std::vector<Due>, std::greater<>> due_;
};

using Steppers = std::vector<std::unique_ptr<Stepper>>;

/// Sleeps until a moment. @return false if is_stopped() ended the sleep earlier.
bool sleepUntil(Clock::time_point moment, const std::function<bool()>& is_stopped) {
  for (Clock::time_point now = Clock::now(); now < moment; now = Clock::now()) {
    if (is_stopped && is_stopped()) return false;
    std::this_thread::sleep_until(std::min(moment, now + kLongestWait));
  }
  return true;
}

double secondsOf(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

LoadCounts countsOf(const Steppers& steppers) {
  LoadCounts counts;
  for (const auto& stepper : steppers) counts.add(stepper->counts());
  return counts;
}

}  // namespace

LoadResult runLoadTest(std::span<LoadPlan> plans, const LoadOptions& options) {
  allowDescriptors(options.clients);
  const Clock::time_point start = Clock::now(), end = start + ofSeconds(options.seconds);
  for (LoadPlan& plan : plans) plan.end = end;
  Steppers steppers;
  for (unsigned i = 0; i < options.threads; ++i) steppers.push_back(std::make_unique<Stepper>());
  for (uint32_t i = 0; i < options.clients; ++i) {
    const double part = static_cast<double>(i) / options.clients;
    const LoadPlan& plan = plans[i % plans.size()];
    Stepper& stepper = *steppers[i % options.threads];
    const Clock::time_point begin = start + ofSeconds(options.ramp_s * part);
    if (options.full)
      stepper.addFull(plan, begin, i);
    else
      stepper.addTrace(plan, begin, plan.trace.duration_s * part);
  }
  {
    std::vector<std::jthread> threads;
    for (const auto& stepper : steppers) threads.emplace_back([&] { stepper->run(end, options.is_stopped); });
    for (unsigned second = 1; options.progress && start + std::chrono::seconds(second) < end; ++second) {
      if (!sleepUntil(start + std::chrono::seconds(second), options.is_stopped)) break;
      options.progress(second, countsOf(steppers));
    }
  }
  const Clock::time_point ended = Clock::now();
  return {countsOf(steppers), std::min(secondsOf(ended - start), options.seconds), ended < end};
}

}  // namespace lode::app
