#include "server/serve/net/open_files.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

namespace lode::serve {

uint64_t raiseOpenFileLimit() noexcept {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  rlimit raised = limit;
  raised.rlim_cur = limit.rlim_max;
  return setrlimit(RLIMIT_NOFILE, &raised) == 0 ? raised.rlim_cur : limit.rlim_cur;
}

void ReserveDescriptor::giveUp() noexcept {
  if (descriptor_ >= 0) close(descriptor_);
  descriptor_ = -1;
}

void ReserveDescriptor::keep() noexcept {
  if (descriptor_ < 0) descriptor_ = open("/dev/null", O_RDONLY | O_CLOEXEC);
}

}  // namespace lode::serve
