#include "server/serve/net/acceptor.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <list>
#include <memory>
#include <new>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "server/serve/memory/memory_reserve.h"
#include "tests/unit/serve/allocations.h"

namespace lode::serve {
namespace {

using asio::ip::tcp;
using namespace std::chrono_literals;

/// An Acceptor without a Server. The test runs its loop as Server::run() does.
class AcceptorTest : public testing::Test {
 protected:
  AcceptorTest() {
    tcp::acceptor acceptor(context_, {asio::ip::address_v4::loopback(), 0});
    address_ = acceptor.local_endpoint();
    acceptor_.emplace(std::move(acceptor), AcceptorOptions{}, admission_, budget_, counters_, log_,
                      [this](const tcp::socket&, const Slot&, const MemoryAccount&, const std::string&) {
                        kept_.emplace_back().resize(blocks_per_connection_);
                        if (hand_throws_) throw std::bad_alloc();
                        if (hand_throws_what_nobody_catches_) throw 1;
                        ++handed_;
                      });
  }
  void turn() {
    try {
      acceptor_->open();
      context_.run_one_for(10ms);
    } catch (...) {  // NOLINT(bugprone-empty-catch): as Server::run() goes on
    }
  }
  void connect() {
    clients_.emplace_back(client_context_);
    clients_.back().connect(address_);
  }
  bool isTakenWithin(std::chrono::steady_clock::duration time) {
    const auto end = std::chrono::steady_clock::now() + time;
    const int before = handed_;
    connect();
    while (handed_ == before && std::chrono::steady_clock::now() < end) turn();
    return handed_ > before;
  }

  /// Closed after the log, which writes to it.
  struct Quiet {
    ~Quiet() { ::close(descriptor); }
    const int descriptor = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  };

  const Quiet quiet_{};
  asio::io_context context_, client_context_;
  Admission admission_{1000, {}};
  MemoryBudget budget_{1u << 20};
  ThreadCounters counters_;
  Log log_{{.descriptor = quiet_.descriptor}};
  std::optional<Acceptor> acceptor_;
  tcp::endpoint address_;
  std::vector<tcp::socket> clients_;
  bool hand_throws_ = false, hand_throws_what_nobody_catches_ = false;
  size_t blocks_per_connection_ = 0;  ///< number of allocations per connection
  std::vector<std::list<std::array<std::byte, 900>>> kept_;
  int handed_ = 0;
};

TEST_F(AcceptorTest, acceptsTheNextConnectionAfterOneFailsForLackOfMemory) {
  hand_throws_ = true;
  EXPECT_FALSE(isTakenWithin(50ms));
  EXPECT_EQ(admission_.count(), 0u);
  EXPECT_EQ(budget_.used(), 0u);
  hand_throws_ = false;
  EXPECT_TRUE(isTakenWithin(60s));
}

TEST_F(AcceptorTest, acceptsTheNextConnectionAfterAnUncaughtException) {
  hand_throws_what_nobody_catches_ = true;
  EXPECT_FALSE(isTakenWithin(50ms));
  hand_throws_what_nobody_catches_ = false;
  EXPECT_TRUE(isTakenWithin(60s));
}

TEST_F(AcceptorTest, acceptsTheNextConnectionWhereverMemoryRunsOut) {
  ASSERT_TRUE(isTakenWithin(60s));
  for (size_t nth = 0, failed = 1; failed > 0; ++nth) {
    connect();
    hand_throws_ = true;  // tests the recovery from the first failure, too
    {
      const auto failing = test::FailingAllocations::nthOf(std::this_thread::get_id(), nth);
      const auto end = std::chrono::steady_clock::now() + 20ms;
      while (std::chrono::steady_clock::now() < end) turn();
      failed = failing.failed();
    }
    hand_throws_ = false;
    ASSERT_TRUE(isTakenWithin(60s)) << "after allocation " << nth << " had failed";
  }
  EXPECT_EQ(admission_.count(), 0u);
}

#ifndef LODE_SANITIZED  // sanitizers end the process when memory runs out

TEST_F(AcceptorTest, leavesTheReserveToAcceptedConnections) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto acceptWithoutMemory = [this] {
    const MemoryReserve reserve;
    for (int i = 0; i < 400; ++i) connect();
    blocks_per_connection_ = 4;
    kept_.reserve(400);
    test::takeAllMemory();
    for (int i = 0; i < 50; ++i) turn();
    std::fprintf(stderr, "%zu blocks for %d connections\n", MemoryReserve::taken(), handed_);
    std::_Exit(0);
  };
  EXPECT_EXIT(acceptWithoutMemory(), testing::ExitedWithCode(0), "^[1-9][0-9]? blocks for [0-9] connections");
}

#endif

}  // namespace
}  // namespace lode::serve
