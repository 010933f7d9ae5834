#include "client/loadtest/load_test.h"

#include <algorithm>
#include <atomic>
#include <ctime>
#include <thread>
#include <vector>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <gtest/gtest.h>

#include "client/core/view/framing.h"
#include "server/store/reader.h"
#include "tests/support/synthetic_store.h"
#include "tests/support/work_folder.h"
#include "tests/unit/app/told_server.h"

namespace lode::app {
namespace {

double processSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Returns a port at which no program listens.
uint16_t closedPort() {
  asio::io_context io;
  return asio::ip::tcp::acceptor(io, {asio::ip::address_v4::loopback(), 0}).local_endpoint().port();
}

LoadPlan planAt(uint16_t port) {
  LoadPlan plan;
  plan.model = {{"127.0.0.1", port}, "a"};
  plan.route = {plan.model.address};
  plan.path_of = [](const ModelSummary& summary, uint64_t) { return core::framingCamera(summary); };
  return plan;
}

LoadOptions optionsOf(uint32_t clients, unsigned threads, double seconds) {
  LoadOptions options;
  options.clients = clients;
  options.threads = threads;
  options.seconds = seconds;
  options.ramp_s = 0;
  options.full = true;
  return options;
}

TEST(LoadTest, usesLittleCpuWhileNoClientIsConnected) {
  std::vector<LoadPlan> plans{planAt(closedPort())};
  const double before_s = processSeconds();
  runLoadTest(plans, optionsOf(1, 4, 1));
  EXPECT_LT(processSeconds() - before_s, 0.5) << "of four threads in a second";
}

TEST(LoadTest, addsUpTheCountsOfAllThreads) {
  const lode::test::WorkFolder folder;
  lode::test::SyntheticModel model = lode::test::makeModel(lode::test::makeSphere(24, 16));
  lode::test::writeStore(folder / "a.lode", model);
  const store::Reader store(folder / "a.lode");
  asio::io_context io{1};
  ToldServer server(io, store);
  std::vector<LoadPlan> plans{planAt(server.port())};
  std::vector<uint64_t> told;
  LoadOptions options = optionsOf(6, 3, 120);
  std::atomic<bool> has_all = false;
  options.progress = [&](double, const LoadCounts& counts) {
    told.push_back(counts.blobs);
    has_all = counts.first_image.count() == 6;
  };
  options.is_stopped = [&] { return has_all.load(); };
  LoadResult result;
  {
    const std::jthread serving([&] { io.run(); });
    result = runLoadTest(plans, options);
    io.stop();
  }
  EXPECT_EQ(result.counts.started, 6u);
  EXPECT_EQ(result.counts.first_image.count(), 6u);
  EXPECT_EQ(result.counts.errorCount(), 0u) << result.counts.first_error;
  EXPECT_TRUE(result.interrupted);
  EXPECT_TRUE(std::ranges::is_sorted(told));
  EXPECT_GT(told.back(), 0u);
  EXPECT_LE(told.back(), result.counts.blobs);
}

}  // namespace
}  // namespace lode::app
