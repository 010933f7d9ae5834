#include "server/serve/ops/log_sink.h"

#include <string>

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

namespace lode::serve {

LogSink::LogSink(int descriptor) noexcept : descriptor_(descriptor) {
  struct stat about {};
  if (fstat(descriptor, &about) != 0) return;
  is_socket_ = S_ISSOCK(about.st_mode);
  if (!S_ISFIFO(about.st_mode)) return;
  const std::string path = "/proc/self/fd/" + std::to_string(descriptor);
  own_ = open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
}

LogSink::~LogSink() {
  if (own_ >= 0) close(own_);
}

bool LogSink::ready() const noexcept {
  pollfd waiting{descriptor_, POLLOUT, 0};
  return poll(&waiting, 1, 0) == 1 && (waiting.revents & POLLOUT) != 0;
}

bool LogSink::write(std::string_view line) noexcept {
  ssize_t taken = -1;
  if (is_socket_)
    taken = send(descriptor_, line.data(), line.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  else if (own_ >= 0)
    taken = ::write(own_, line.data(), line.size());
  else if (ready())
    taken = ::write(descriptor_, line.data(), line.size());
  return taken == static_cast<ssize_t>(line.size());
}

}  // namespace lode::serve
