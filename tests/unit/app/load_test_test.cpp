#include "client/app/cli/load_test.h"

#include <ctime>
#include <vector>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <gtest/gtest.h>

namespace lode::app {
namespace {

double processSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// A port at which nobody listens any more.
uint16_t closedPort() {
  asio::io_context io;
  return asio::ip::tcp::acceptor(io, {asio::ip::address_v4::loopback(), 0}).local_endpoint().port();
}

TEST(LoadTest, restsWhileNoClientHasAConnection) {
  std::vector<LoadPlan> plans(1);
  plans[0].model = {{"127.0.0.1", closedPort()}, "a"};
  plans[0].route = {plans[0].model.address};
  const double before_s = processSeconds();
  runLoadTest(plans, {.clients = 1,
                      .threads = 4,
                      .seconds = 1,
                      .ramp_s = 0,
                      .full = true,
                      .progress = {},
                      .is_stopped = {}});
  EXPECT_LT(processSeconds() - before_s, 0.5) << "of four threads in a second";
}

}  // namespace
}  // namespace lode::app
