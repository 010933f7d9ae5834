#include "server/serve/worker.h"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <latch>
#include <optional>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "server/serve/session/catalog.h"
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

/// A worker with one connection and a disk under control of the test: reads that wait for the disk end when
/// the test lets them, and one is read at a time.
class WorkerTest : public testing::Test {
 protected:
  WorkerTest() {
    writeSmallStore(store_, 1, kColdBytes);
    BlobReaderOptions options{
        .report =
            [this](StoreFault, std::string_view line) {
              if (line.find("again") != line.npos) is_readable_again_ = true;
            },
        .read = [this](int file, uint64_t offset, auto into) { return readBlob(file, offset, into); }};
    std::vector<std::shared_ptr<const Model>> models{openModel(store_, options)};
    const std::filesystem::path always_cold = folder_.path() / "cold.lode";
    writeSmallStore(always_cold, 1, kColdBytes);
    options.hot_reads = false;
    models.push_back(openModel(always_cold, options));
    catalog_ = std::make_shared<const Catalog>(std::move(models));
    worker_.emplace(Published{{catalog_, nullptr}, nullptr},
                    WorkerShared{log_, disk_, budget_, rate_, wrong_tokens_, {}}, counters_);
    worker_->start(10ms);
  }
  ~WorkerTest() override {
    if (!answered_) letDiskAnswer();
    worker_->halt();
    worker_->join();
    disk_.join();
  }

  static std::shared_ptr<const Model> openModel(const std::filesystem::path& store,
                                                const BlobReaderOptions& options) {
    return openCatalog(std::span(&store, 1), options)->models().front();
  }
  std::optional<size_t> readBlob(int file, uint64_t offset, std::span<std::byte> into) {
    ++reads_;
    disk_answers_.wait();
    const auto bytes = readAt(file, offset, into);
    ++ended_reads_;
    if (!read_fails_) return bytes;
    errno = EIO;
    return std::nullopt;
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
  WrongTokens wrong_tokens_{50ms};
  Admission admission_{10, {}};
  std::shared_ptr<const Catalog> catalog_;
  std::latch disk_answers_{1};
  bool answered_ = false;
  std::atomic<bool> read_fails_{false}, is_readable_again_{false};
  std::atomic<int> reads_{0}, ended_reads_{0}, now_s_{0};
  DiskReaders disk_{{.threads = 1, .reads_per_store = 1, .clock = [this] {
                       return DiskReaders::TimePoint(std::chrono::seconds(now_s_));
                     }}};
  asio::io_context context_;
  tcp::acceptor acceptor_{context_, {asio::ip::address_v4::loopback(), 0}};
  std::optional<Worker> worker_;
};

TEST_F(WorkerTest, answersOtherFramesDuringAColdRead) {
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

TEST_F(WorkerTest, readsAnUrgentRequestWhileFinishedReadsWaitForTheWindow) {
  letDiskAnswer();
  const auto client = connect();
  const proto::Opened opened = client->open("cold");
  client->blobs(2);
  proto::Requests many{opened.handle, {}};
  for (uint32_t request = 1; request <= 20; ++request)
    many.changes.push_back({RequestAction::kAdd, RequestClass::kPrefetch, request, kColdBlob, 1});
  client->send(many);
  uint64_t received_bytes = 0;
  while (received_bytes < proto::kInitialWindowBytes / 2) {  // then finished reads wait for the window
    const auto frame = client->receive();
    ASSERT_TRUE(frame && frame->is(FrameType::kBlob));
    received_bytes += frame->body.size();
  }
  while (ended_reads_ < 10)
    std::this_thread::yield();  // two unasked blobs, and as many as a connection may read
  const uint32_t urgent = 100;
  client->send(
      proto::Requests{opened.handle, {{RequestAction::kAdd, RequestClass::kVisible, urgent, kColdBlob, 1}}});
  client->send(proto::Credit{1ull << 40});
  while (true) {
    const auto frame = client->receive();
    ASSERT_TRUE(frame && frame->is(FrameType::kBlob));
    if (proto::decodeBlobChunk(frame->body).header.request == urgent) break;
  }
}

TEST_F(WorkerTest, endsARequestWithAFailedReadAsRepeatable) {
  letDiskAnswer();
  const auto client = connect();
  const proto::Opened opened = client->open("a");
  client->blobs(2);
  read_fails_ = true;
  const auto ask = [&](uint32_t request) {
    client->send(proto::Requests{opened.handle,
                                 {{RequestAction::kAdd, RequestClass::kVisible, request, kColdBlob, 1}}});
  };
  ask(1);
  const auto error = client->expect<proto::ErrorMessage>(FrameType::kError);
  EXPECT_EQ(error.code, proto::WireError::kInternal);
  EXPECT_EQ(error.request, 1u);
  EXPECT_NE(error.message.find("cannot be read"), std::string::npos) << error.message;
  EXPECT_EQ(error.message.find("damage"), std::string::npos) << error.message;
  EXPECT_EQ(counters_.model("a").unreadable.read(), 1u);
  EXPECT_EQ(counters_.model("a").damaged.read(), 0u);
  read_fails_ = false;
  ask(2);
  EXPECT_EQ(client->blobs(1)[0].first, 2u);
}

TEST_F(WorkerTest, aReadThatHangsEndsItsRequestAtTheDeadlineAndLaterOnesAtOnce) {
  const auto client = connect();
  const proto::Opened opened = client->open("a");
  client->blobs(2);
  const auto expectUnreadable = [&](uint32_t request) {
    const auto error = client->expect<proto::ErrorMessage>(FrameType::kError);
    EXPECT_EQ(error.code, proto::WireError::kInternal);
    EXPECT_EQ(error.request, request);
  };
  const auto ask = [&](uint32_t request) {
    client->send(proto::Requests{opened.handle,
                                 {{RequestAction::kAdd, RequestClass::kVisible, request, kColdBlob, 1}}});
  };
  ask(1);
  while (reads_ == 0) std::this_thread::yield();
  now_s_ = 10;
  disk_.tick();
  expectUnreadable(1);
  ask(2);
  expectUnreadable(2);
  letDiskAnswer();
  while (!is_readable_again_) std::this_thread::yield();
  ask(3);
  for (uint32_t request = 4;; ++request) {  // the late read may not have returned its slot yet
    const auto frame = client->receive();
    ASSERT_TRUE(frame);
    if (frame->is(FrameType::kBlob)) break;
    ask(request);
  }
}

}  // namespace
}  // namespace lode::serve
