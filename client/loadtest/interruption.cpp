#include "client/loadtest/interruption.h"

#include <atomic>
#include <cstddef>

namespace lode::app {
namespace {

constexpr std::array kSignals{SIGINT, SIGTERM};
std::atomic<int> signal_that_came{0};
static_assert(std::atomic<int>::is_always_lock_free);

}  // namespace

Interruption::Interruption() {
  signal_that_came = 0;
  struct sigaction action {};
  action.sa_handler = [](int number) { signal_that_came = number; };
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  for (size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &action, &before_[i]);
}

Interruption::~Interruption() {
  for (size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

int Interruption::signal() noexcept { return signal_that_came; }

}  // namespace lode::app
