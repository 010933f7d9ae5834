// Emulates a long link between two network namespaces, for load and fault tests on one machine. Joins two TUN
// devices named em0, one in each namespace, by a queue with delay, rate and loss in each direction; TCP runs
// over it unchanged. Works on kernels without netem. Needs root.
//   ip netns add A; ip netns add B
//   ./wan A B 25 10 0 200 &          # 25 ms one way, 10 Mbit/s, 0 % loss, 200 ms queue; prints "ready"
//   ip -n A addr add 10.9.0.1/24 dev em0; ip -n A link set em0 up; ip -n A link set lo up
//   ip -n B addr add 10.9.0.2/24 dev em0; ip -n B link set em0 up; ip -n B link set lo up
//   ip netns exec A lodestreamd serve …;  ip netns exec B lodestream fetch lode://10.9.0.1/…
// Carries up to about 1 Gbit/s.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <random>
#include <vector>

#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <sched.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <sys/timerfd.h>
#include <unistd.h>

namespace {

double nowSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

[[noreturn]] void fail(const char* what) {
  std::perror(what);
  std::exit(1);
}

/// Opens a TUN device called em0 inside the named network namespace.
int openTun(const char* netns) {
  char path[128];
  std::snprintf(path, sizeof path, "/run/netns/%s", netns);
  const int ns = open(path, O_RDONLY);
  if (ns < 0 || setns(ns, CLONE_NEWNET) != 0) fail(path);
  const int fd = open("/dev/net/tun", O_RDWR | O_NONBLOCK);
  ifreq request{};
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  std::strcpy(request.ifr_name, "em0");
  if (fd < 0 || ioctl(fd, TUNSETIFF, &request) != 0) fail("/dev/net/tun");
  return fd;
}

struct Packet {
  double due_s;
  std::vector<char> bytes;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) {
    std::fprintf(stderr, "usage: wan NETNS_A NETNS_B DELAY_MS RATE_MBIT LOSS_PERCENT QUEUE_MS\n");
    return 2;
  }
  const int fds[2] = {openTun(argv[1]), openTun(argv[2])};
  const double delay_s = std::atof(argv[3]) / 1e3;
  const double bytes_per_s = std::atof(argv[4]) * 1e6 / 8;
  const double loss = std::atof(argv[5]) / 100;
  const double queue_s = std::atof(argv[6]) / 1e3;
  std::puts("ready");
  std::fflush(stdout);

  std::deque<Packet> in_flight[2];
  double link_free_s[2] = {0, 0};
  std::mt19937 random(1);
  std::uniform_real_distribution<> uniform;
  const int timer = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK);
  const int poll = epoll_create1(0);
  for (const int fd : {fds[0], fds[1], timer}) {
    epoll_event event{EPOLLIN, {}};
    epoll_ctl(poll, EPOLL_CTL_ADD, fd, &event);
  }
  static char buffer[65536];
  for (;;) {
    epoll_event events[4];
    epoll_wait(poll, events, 4, -1);
    std::uint64_t expirations;
    (void)!read(timer, &expirations, sizeof expirations);
    for (int side = 0; side < 2; ++side) {
      for (int budget = 0; budget < 256; ++budget) {
        const ssize_t size = read(fds[side], buffer, sizeof buffer);
        if (size <= 0) break;
        double sent_s = nowSeconds();
        if (uniform(random) < loss) continue;
        if (bytes_per_s > 0) {
          const double start_s = std::max(sent_s, link_free_s[side]);
          if (start_s - sent_s > queue_s) continue;  // the link's queue is full
          sent_s = link_free_s[side] = start_s + static_cast<double>(size) / bytes_per_s;
        }
        in_flight[side].push_back({sent_s + delay_s, {buffer, buffer + size}});
      }
    }
    double next_s = INFINITY;
    for (int side = 0; side < 2; ++side) {
      auto& queue = in_flight[side];
      for (; !queue.empty() && queue.front().due_s <= nowSeconds(); queue.pop_front()) {
        (void)!write(fds[1 - side], queue.front().bytes.data(), queue.front().bytes.size());
      }
      if (!queue.empty()) next_s = std::min(next_s, queue.front().due_s);
    }
    itimerspec wake{};
    if (std::isfinite(next_s)) {
      wake.it_value.tv_sec = static_cast<time_t>(next_s);
      wake.it_value.tv_nsec = static_cast<long>((next_s - std::floor(next_s)) * 1e9);
    }
    timerfd_settime(timer, TFD_TIMER_ABSTIME, &wake, nullptr);
  }
}
