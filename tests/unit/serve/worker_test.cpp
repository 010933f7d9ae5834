#include "server/serve/worker.h"

#include <chrono>
#include <climits>
#include <future>
#include <latch>

#include <asio/post.hpp>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "common/error.h"
#include "server/serve/session/catalog.h"
#include "tests/support/scarce_threads.h"
#include "tests/unit/serve/small_store.h"
#include "tests/unit/serve/test_client.h"

namespace lode::serve {
namespace {

using namespace test;
using asio::ip::tcp;
using proto::FrameType;
using proto::RequestAction;
using proto::RequestClass;
using namespace std::chrono_literals;

/// Larger than kMaxCheckedHotBytes, so that the server always reads it on a reader thread. (A smaller blob
/// that was evicted from the page cache may be back when the server reads it.)
constexpr uint32_t kColdBlob = 1;
constexpr size_t kColdBytes = 300'000;

/// A worker with one connection and a disk under control of the test: the only reader thread first waits for
/// the test.
class WorkerTest : public testing::Test {
 protected:
  WorkerTest() {
    writeSmallStore(store_, 1, kColdBytes);
    catalog_ = openCatalog(std::span(&store_, 1), {.report = [](std::string_view) {}});
    asio::post(disk_, [this] { disk_answers_.wait(); });
    worker_.emplace(Published{{catalog_, nullptr}, nullptr}, log_, counters_, disk_, budget_, rate_,
                    ConnectionLimits{});
    worker_->start(10ms);
  }
  ~WorkerTest() override {
    if (!answered_) letDiskAnswer();
    worker_->halt();
    worker_->join();
    disk_.join();
  }

  void letDiskAnswer() {
    answered_ = true;
    disk_answers_.count_down();
  }
  std::unique_ptr<TestClient> connect() {
    auto client = std::make_unique<TestClient>(acceptor_.local_endpoint().port());
    MemoryAccount memory(budget_);
    memory.admit(kPlainConnectionBytes);
    worker_->give(acceptor_.accept(), *admission_.enter(), std::move(memory), "client");
    return client;
  }

  /// Closed after the log, which writes to it.
  struct Quiet {
    ~Quiet() { ::close(descriptor); }
    const int descriptor = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  };

  WorkFolder folder_;
  const std::filesystem::path store_ = folder_.path() / "a.lode";
  const Quiet quiet_{};
  Log log_{{.descriptor = quiet_.descriptor}};
  ThreadCounters counters_;
  MemoryBudget budget_{64u << 20};
  ByteRate rate_{0};
  Admission admission_{10, {}};
  std::shared_ptr<const Catalog> catalog_;
  std::latch disk_answers_{1};
  bool answered_ = false;
  asio::thread_pool disk_{1};
  asio::io_context context_;
  tcp::acceptor acceptor_{context_, {asio::ip::address_v4::loopback(), 0}};
  std::optional<Worker> worker_;
};

TEST_F(WorkerTest, aColdReadHoldsUpNoAnswerOfItsConnection) {
  const auto client = connect();
  const proto::Opened opened = client->open("a");
  client->blobs(2);
  const auto change = [&](RequestAction action, uint32_t request) {
    client->send(proto::Requests{opened.handle, {{action, RequestClass::kVisible, request, kColdBlob, 1}}});
  };
  change(RequestAction::kAdd, 1);
  client->send(proto::Ping{7}, 3);
  EXPECT_EQ(client->expect<proto::Pong>(FrameType::kPong).payload, 7u);
  change(RequestAction::kCancel, 1);
  EXPECT_EQ(client->expect<proto::Cancelled>(FrameType::kCancelled).request, 1u);
  change(RequestAction::kAdd, 2);
  letDiskAnswer();
  const auto blobs = client->blobs(1);
  ASSERT_EQ(blobs.size(), 1u);
  EXPECT_EQ(blobs[0].first, 2u);
  EXPECT_EQ(blobs[0].second, store::Reader(store_).readBlob(kColdBlob));
}

TEST(ReaderThreads, failAndEndWhereTheSystemDoesNotGiveAll) {
  for (const int threads : {0, 1, 2, 3}) {
    lode::test::threads_left = threads;
    EXPECT_THROW(ReaderThreads(4), Error) << threads;
  }
  lode::test::threads_left = INT_MAX;
}

TEST(ReaderThreads, waitForTheDiskBesideOneAnother) {
  ReaderThreads readers(4);
  std::promise<void> first_came, last_came;
  bool came_meanwhile = false;
  asio::post(readers.pool(), [&] {
    first_came.set_value();
    came_meanwhile = last_came.get_future().wait_for(std::chrono::seconds(300)) == std::future_status::ready;
  });
  first_came.get_future().wait();
  asio::post(readers.pool(), [&] { last_came.set_value(); });
  readers.join();
  EXPECT_TRUE(came_meanwhile);
}

}  // namespace
}  // namespace lode::serve
