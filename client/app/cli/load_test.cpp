#include "client/app/cli/load_test.h"

#include <algorithm>
#include <memory>
#include <queue>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <sys/resource.h>

#include "common/error.h"

namespace lode::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLongestWait = std::chrono::milliseconds(100);
constexpr unsigned kMostAtOnce = 1024;    ///< events between two looks at the clock
constexpr rlim_t kOtherDescriptors = 64;  ///< that the process needs besides its connections

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

/// Some of the clients, and the loop that steps them.
class Stepper {
 public:
  explicit Stepper(const LoadPlan& plan) : plan_(plan) {}

  void add(Clock::time_point start, double phase_s) {
    clients_.push_back(std::make_unique<LoadClient>(io_, plan_, start, phase_s, names_, tally_));
    due_.push({start, clients_.size() - 1});
  }

  void run() {
    for (Clock::time_point now = Clock::now(); now < plan_.end; now = Clock::now()) {
      const Clock::time_point next = due_.empty() ? plan_.end : std::min(due_.top().first, plan_.end);
      if (next > now) io_.run_one_until(std::min(next, now + kLongestWait));
      for (unsigned i = 0; i < kMostAtOnce && io_.poll_one() > 0; ++i) continue;
      io_.restart();
      stepDue(std::min(Clock::now(), plan_.end));
    }
    for (const auto& client : clients_) client->finish(plan_.end);
    clients_.clear();
  }

  const LoadTally& tally() const noexcept { return tally_; }

 private:
  /// @param now  not after the end: clients have nothing to do from then on.
  void stepDue(Clock::time_point now) {
    while (!due_.empty() && due_.top().first <= now) {
      const size_t client = due_.top().second;
      due_.pop();
      clients_[client]->step(now);
      if (clients_[client]->due() != Clock::time_point::max()) due_.push({clients_[client]->due(), client});
    }
  }

  const LoadPlan& plan_;
  KnownNames names_;
  LoadTally tally_;
  asio::io_context io_{1};
  std::vector<std::unique_ptr<LoadClient>> clients_;
  using Due = std::pair<Clock::time_point, size_t>;
  std::priority_queue<Due, std::vector<Due>, std::greater<>> due_;
};

}  // namespace

LoadTally runLoadTest(LoadPlan plan, const LoadOptions& options) {
  allowDescriptors(options.clients);
  const Clock::time_point start = Clock::now();
  plan.end = start + ofSeconds(options.seconds);
  const double ramp_s = options.seconds / 4;
  std::vector<std::unique_ptr<Stepper>> steppers;
  for (unsigned i = 0; i < options.threads; ++i) steppers.push_back(std::make_unique<Stepper>(plan));
  for (uint32_t i = 0; i < options.clients; ++i) {
    const double part = static_cast<double>(i) / options.clients;
    steppers[i % options.threads]->add(start + ofSeconds(ramp_s * part), plan.trace.duration_s * part);
  }
  {
    std::vector<std::jthread> threads;
    for (const auto& stepper : steppers) threads.emplace_back([&stepper] { stepper->run(); });
  }
  LoadTally tally;
  for (const auto& stepper : steppers) tally.add(stepper->tally());
  return tally;
}

}  // namespace lode::app
