#include "server/app/service_notice.h"

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "common/error.h"

namespace lode::app {

namespace {

constexpr int kFirstSocketOfService = 3;

/// Returns the number in an environment variable, or -1 if the variable is not set.
long numberIn(const char* variable) noexcept {
  const char* const text = std::getenv(variable);
  return text == nullptr ? -1 : std::strtol(text, nullptr, 10);
}

}  // namespace

std::optional<int> socketOfService() {
  if (numberIn("LISTEN_PID") != ::getpid() || numberIn("LISTEN_FDS") < 1) return {};
  if (numberIn("LISTEN_FDS") > 1)
    throw Error(ErrorCode::kUsage, "the service manager passes " + std::to_string(numberIn("LISTEN_FDS")) +
                                       " sockets; give the socket unit a single ListenStream");
  ::fcntl(kFirstSocketOfService, F_SETFD, FD_CLOEXEC);
  return kFirstSocketOfService;
}

void notifyService(const std::string& state) noexcept {
  const char* const named = std::getenv("NOTIFY_SOCKET");
  if (named == nullptr) return;
  const std::string_view path = named;
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  if (path.size() < 2 || path.size() >= sizeof(to.sun_path)) return;
  std::memcpy(to.sun_path, path.data(), path.size());
  if (path[0] == '@') to.sun_path[0] = '\0';  // the name of an abstract socket begins with a zero byte
  const int descriptor = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return;
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  ::sendto(descriptor, state.data(), state.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&to),
           length);
  ::close(descriptor);
}

std::string monotonicMicroseconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::to_string(now.tv_sec * 1'000'000 + now.tv_nsec / 1000);
}

}  // namespace lode::app
