#include "server/app/interruption.h"

#include <cerrno>
#include <cstdio>
#include <ctime>
#include <system_error>

#include "common/error.h"
#include "common/io/interrupted.h"

namespace lode::app {
namespace {

constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};
constexpr long kGraceNs = 500'000'000;  ///< time in which the work can end by itself
constexpr long kSecondNs = 1'000'000'000;
volatile std::sig_atomic_t received = 0;
sem_t wake;  ///< posted by each signal and by the destructor of Interruption

void note(int signal) {
  received = signal;
  ::sem_post(&wake);
}

void waitFor(sem_t& semaphore) noexcept {
  while (::sem_wait(&semaphore) != 0 && errno == EINTR) continue;
}

/// Waits for kGraceNs at most. @return true if the semaphore was posted.
bool waitForGrace(sem_t& semaphore) noexcept {
  timespec until{};
  ::clock_gettime(CLOCK_REALTIME, &until);
  until.tv_nsec += kGraceNs;
  until.tv_sec += until.tv_nsec / kSecondNs;
  until.tv_nsec %= kSecondNs;
  while (::sem_timedwait(&semaphore, &until) != 0)
    if (errno != EINTR) return false;
  return true;
}

}  // namespace

Interruption::Interruption(const char* message, const char* hint)
    : message_(message), forced_message_(std::string(message) + hint) {
  received = 0;
  ::sem_init(&wake, 0, 0);
  ::sem_init(&ended_, 0, 0);
  try {
    watcher_ = std::jthread([this] { endAfterGrace(); });
  } catch (const std::system_error&) {
    // Ignore a failure: without this thread, a signal still ends the work at its next check().
  }
  struct sigaction action {};
  action.sa_handler = note;
  action.sa_flags = SA_RESTART;
  for (size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], &action, &before_[i]);
    if (before_[i].sa_handler == SIG_IGN)
      sigaction(kSignals[i], &before_[i], nullptr);  // keep the signal ignored, as under nohup
  }
}

Interruption::~Interruption() {
  for (size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
  ::sem_post(&ended_);
  ::sem_post(&wake);
  if (watcher_.joinable()) watcher_.join();
  ::sem_destroy(&ended_);
}

void Interruption::endAfterGrace() {
  waitFor(wake);
  if (received != 0 && !waitForGrace(ended_)) endInterrupted(received, forced_message_.c_str());
}

void Interruption::check() const {
  if (received != 0) throw Error(ErrorCode::kIo, message_);
}

void Interruption::endProcessIfReceived(const char* message) const {
  if (received == 0) return;
  std::fprintf(stderr, "lodestreamd: %s\n", message);
  std::signal(received, SIG_DFL);
  std::raise(received);
}

}  // namespace lode::app
