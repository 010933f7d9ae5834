#include "server/app/interruption.h"

#include <cstdio>

#include "common/error.h"

namespace lode::app {
namespace {

constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};
volatile std::sig_atomic_t received = 0;

void note(int signal) { received = signal; }

}  // namespace

Interruption::Interruption(const char* message) : message_(message) {
  received = 0;
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
