// Tests of the counters of full and trace clients whose server shuts down, disconnects, refuses requests or
// falls silent.

#include "client/loadtest/load_client.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <asio/io_context.hpp>
#include <gtest/gtest.h>

#include "client/core/view/framing.h"
#include "client/loadtest/full_client.h"
#include "client/loadtest/trace_client.h"
#include "proto/limits.h"
#include "server/store/reader.h"
#include "tests/support/synthetic_store.h"
#include "tests/unit/app/told_server.h"

namespace lode::app {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

enum class Kind { kFull, kTrace };

class EveryLoadClient : public testing::TestWithParam<Kind> {
 protected:
  void SetUp() override {
    lode::test::SyntheticModel model = lode::test::makeModel(lode::test::makeSphere(24, 16));
    prepare(model);
    lode::test::writeStore(folder_ / "a.lode", model);
    store_.emplace(folder_ / "a.lode");
    uint64_t bytes = 0;  // all blobs fit into the initial window, and each into one frame
    for (uint32_t blob = 1; blob <= store_->blobCount(); ++blob) bytes += store_->blob(blob).bytes;
    ASSERT_LT(bytes, proto::kMaxChunkBytes);
    server_.emplace(io_, *store_);
    plan_.model = {{"127.0.0.1", server_->port()}, "a"};
    plan_.route = {plan_.model.address};
    plan_.path_of = [](const ModelSummary& summary, uint64_t) { return core::framingCamera(summary); };
    plan_.pixels = 0.01f;
    plan_.fps = 100;
    plan_.end = start_;  // the client replays the trace once
    plan_.trace.build_id = store_->summary().build_id;
    for (const Node& node : store_->nodes())
      if (node.isLeaf())
        plan_.trace.requests.push_back(
            {0, {node.lods[0].payload, {core::BlobKind::kMesh, {node.key, 0}}}, {}});
    makeClient();
  }

  /// Replaces the client by one that retries for a time although it has never opened the model.
  void patient(std::chrono::nanoseconds patience) {
    plan_.options.engine.session.open_patience = patience;
    makeClient();
  }

  void makeClient() {
    if (GetParam() == Kind::kFull)
      client_ = std::make_unique<FullClient>(io_, plan_, start_, 1, names_, counts_);
    else
      client_ = std::make_unique<TraceClient>(io_, plan_, start_, 0, names_, counts_);
  }

  virtual void prepare(lode::test::SyntheticModel& /*model*/) {}

  /// Runs the client and the server until the condition holds.
  template <typename Done>
  void run(const Done& done) {
    for (const auto deadline = Clock::now() + 60s; !done(); turn()) {
      ASSERT_NE(client_->due(), kNever) << counts_.first_error;
      ASSERT_LT(Clock::now(), deadline) << "it did not come to that";
    }
  }
  /// Runs the client and the server until no messages are in transit.
  void settle() {
    for (int turns = 0; turns < 50; ++turns) turn();
  }
  /// Runs until the server has received all requests that the client can make.
  void runUntilRequested(size_t connection) {
    run([&] { return server_->openRequests(connection) > 0; });
    settle();
  }
  void runUntilOpened(size_t count) {
    run([&] { return server_->opened() == count; });
  }
  /// Returns the number of requests with a measured latency.
  uint64_t timed() const {
    uint64_t count = 0;
    for (const LatencyHistogram& of_class : counts_.latency) count += of_class.count();
    return count;
  }
  void turn() {
    if (const core::TimePoint now = Clock::now(); client_->due() <= now) client_->step(now);
    io_.restart();
    io_.run_one_for(1ms);
    io_.poll();
  }

  const core::TimePoint start_ = Clock::now();
  const lode::test::WorkFolder folder_;
  asio::io_context io_{1};
  std::optional<store::Reader> store_;
  std::optional<ToldServer> server_;
  LoadPlan plan_;
  KnownDigests names_;
  LoadCounts counts_;
  std::unique_ptr<LoadClient> client_;
};

TEST_P(EveryLoadClient, countsOpenRequestsAsFailedWhenTheServerBreaksOff) {
  server_->holdBack(true);
  runUntilRequested(0);
  const size_t open = server_->openRequests(0);
  server_->breakOff(0);
  runUntilRequested(1);
  EXPECT_EQ(counts_.lost, 1u);
  EXPECT_EQ(counts_.failed_requests, open);
  EXPECT_EQ(counts_.moved, 0u);
  EXPECT_EQ(server_->openRequests(1), open) << "requested again";
}

TEST_P(EveryLoadClient, countsAConnectionThatBreaksAsAnErrorOfTheNetwork) {
  runUntilOpened(1);
  server_->breakOff(0);
  runUntilOpened(2);
  EXPECT_EQ(counts_.errors, (std::map<ErrorCode, uint64_t>{{ErrorCode::kNetwork, 1}}));
}

TEST_P(EveryLoadClient, countsARefusedConnectionAttemptAsANetworkError) {
  runUntilOpened(1);
  server_->closeToTheNext(2);
  server_->breakOff(0);
  runUntilOpened(2);
  EXPECT_EQ(counts_.errors, (std::map<ErrorCode, uint64_t>{{ErrorCode::kNetwork, 3}}));
}

TEST_P(EveryLoadClient, doesNotGiveUpIfItReconnects) {
  runUntilOpened(1);
  server_->breakOff(0);
  runUntilOpened(2);
  EXPECT_EQ(counts_.gave_up, 0u);
}

TEST_P(EveryLoadClient, givesUpWithOneErrorIfTheFirstConnectionFails) {
  server_->closeToTheNext(1);
  while (client_->due() != kNever) turn();
  EXPECT_EQ(counts_.gave_up, 1u);
  EXPECT_EQ(counts_.errorCount(), 1u);
}

TEST_P(EveryLoadClient, retriesTheFirstConnectionWithinItsPatience) {
  patient(60s);
  server_->closeToTheNext(2);
  runUntilOpened(1);
  EXPECT_EQ(counts_.gave_up, 0u);
  EXPECT_EQ(counts_.errors, (std::map<ErrorCode, uint64_t>{{ErrorCode::kNetwork, 2}}));
}

TEST_P(EveryLoadClient, givesUpWhenItsPatienceEndsWithoutAConnection) {
  patient(1ms);
  server_->closeToTheNext(1000);
  while (client_->due() != kNever) turn();
  EXPECT_EQ(counts_.gave_up, 1u);
}

TEST_P(EveryLoadClient, countsTheFirstPictureAtTheEndIfItGaveUp) {
  server_->closeToTheNext(1);
  while (client_->due() != kNever) turn();
  client_->finish(start_ + 9s);
  EXPECT_EQ(counts_.first_image.count(), 1u);
  EXPECT_GE(counts_.first_image.maxMs(), 9000);
  EXPECT_EQ(counts_.errorCount(), 1u) << "and once as an error";
}

TEST_P(EveryLoadClient, countsNoErrorWhenAServerGoesAway) {
  runUntilOpened(1);
  settle();
  server_->goAway(0);
  runUntilOpened(2);
  server_->breakOff(0);
  settle();
  EXPECT_EQ(counts_.errorCount(), 0u);
}

TEST_P(EveryLoadClient, countsRequestsOfABrokenConnectionAsUnanswered) {
  server_->holdBack(true);
  runUntilRequested(0);
  const size_t open = server_->openRequests(0);
  server_->breakOff(0);
  run([&] { return counts_.lost > 0; });
  client_->finish(Clock::now());
  EXPECT_EQ(counts_.unanswered, open);
}

TEST_P(EveryLoadClient, countsOpenRequestsWhenAServerThatGoesAwayBreaksOff) {
  server_->holdBack(true);
  runUntilRequested(0);
  const size_t open = server_->openRequests(0);
  server_->goAway(0);
  runUntilOpened(2);
  server_->breakOff(0);
  runUntilRequested(1);
  EXPECT_EQ(counts_.lost, 1u);
  EXPECT_EQ(counts_.failed_requests, open);
  EXPECT_EQ(counts_.moved, 1u);
  EXPECT_EQ(server_->openRequests(1), open) << "requested again";
}

TEST_P(EveryLoadClient, countsOpenRequestsWhenTwoServersGoAwayInARow) {
  server_->holdBack(true);
  runUntilRequested(0);
  const size_t open = server_->openRequests(0);
  server_->goAway(0);
  runUntilOpened(2);
  server_->goAway(1);
  runUntilRequested(2);
  EXPECT_EQ(counts_.failed_requests, open);
  EXPECT_EQ(counts_.moved, 2u);
}

TEST_P(EveryLoadClient, receivesOpenRequestsWhileTheNextServerIsSilent) {
  server_->holdBack(true);
  runUntilRequested(0);
  server_->saysNothing();
  server_->goAway(0);
  run([&] { return server_->connections() == 2; });
  const uint64_t before = counts_.blobs, open = server_->openRequests(0);
  server_->grantAll(0);
  settle();
  EXPECT_EQ(counts_.blobs, before + open);
  EXPECT_EQ(counts_.lost, 0u);
  EXPECT_EQ(counts_.failed_requests, 0u);
  EXPECT_NE(client_->due(), kNever) << counts_.first_error;
}

TEST_P(EveryLoadClient, losesNothingIfAServerThatGoesAwayHasAnsweredAll) {
  runUntilOpened(1);
  settle();
  ASSERT_GT(counts_.blobs, plan_.trace.requests.size() / 2);
  server_->goAway(0);
  runUntilOpened(2);
  server_->breakOff(0);
  settle();
  EXPECT_EQ(counts_.lost, 0u);
  EXPECT_EQ(counts_.failed_requests, 0u);
  EXPECT_EQ(counts_.moved, 1u);
}

TEST_P(EveryLoadClient, countsAMoveIfTheServerEndsBeforeItReconnects) {
  runUntilOpened(1);
  settle();
  server_->goAway(0);
  server_->breakOff(0);
  runUntilOpened(2);
  EXPECT_EQ(counts_.moved, 1u);
  EXPECT_EQ(counts_.lost, 0u);
}

TEST_P(EveryLoadClient, countsNoMoveIfTheFirstServerTurnsItAway) {
  server_->turnOneAway();
  runUntilOpened(1);
  EXPECT_EQ(counts_.moved, 0u);
}

TEST_P(EveryLoadClient, losesNoRequestsIfTheNextServerTurnsItAway) {
  server_->holdBack(true);
  runUntilRequested(0);
  server_->turnOneAway();
  server_->goAway(0);
  run([&] { return counts_.turned_away == 1; });
  runUntilOpened(2);
  server_->grantAll(0);
  settle();
  EXPECT_EQ(counts_.lost, 0u) << counts_.first_error;
  EXPECT_EQ(counts_.failed_requests, 0u);
}

TEST_P(EveryLoadClient, countsNoErrorIfItIsTurnedAwayAndAdmittedLater) {
  server_->turnOneAway();
  runUntilOpened(1);
  settle();
  client_->finish(Clock::now());
  EXPECT_EQ(counts_.turned_away, 1u);
  EXPECT_EQ(counts_.errorCount(), 0u) << counts_.first_error;
}

TEST_P(EveryLoadClient, countsAnErrorIfItIsNeverAdmitted) {
  server_->turnOneAway();
  run([&] { return counts_.turned_away == 1; });
  client_->finish(Clock::now());
  EXPECT_EQ(counts_.errorCount(), 1u);
  EXPECT_NE(counts_.first_error.find("maintenance"), std::string::npos) << counts_.first_error;
}

TEST_P(EveryLoadClient, timesARepeatedRequestOnceFromItsFirstSending) {
  server_->holdBack(true);
  runUntilRequested(0);
  server_->breakOff(0);
  server_->closeToTheNext(2);
  server_->holdBack(false);
  const core::TimePoint broken_off = Clock::now();
  runUntilOpened(2);
  const std::chrono::duration<double, std::milli> until_opened = Clock::now() - broken_off;
  settle();
  client_->finish(Clock::now());
  EXPECT_EQ(counts_.unanswered, 0u);
  EXPECT_EQ(timed(), server_->granted());
  double longest_ms = 0;
  for (const LatencyHistogram& of_class : counts_.latency)
    longest_ms = std::max(longest_ms, of_class.maxMs());
  EXPECT_GE(longest_ms, until_opened.count());
}

TEST_P(EveryLoadClient, countsNoUnansweredRequestsIfTheyAreNoLongerWanted) {
  server_->holdBack(true);
  runUntilRequested(0);
  server_->breakOff(0);
  run([&] { return counts_.lost > 0; });
  plan_.pixels = 10000;  // the resident LODs suffice for this threshold
  server_->holdBack(false);
  runUntilOpened(2);
  settle();
  client_->finish(Clock::now());
  EXPECT_EQ(counts_.unanswered, 0u);
  EXPECT_EQ(timed(), server_->granted());
}

TEST_P(EveryLoadClient, countsTheFirstPictureAtTheEndIfNoneArrived) {
  server_->saysNothing();
  for (int turns = 0; turns < 20; ++turns) turn();
  client_->finish(start_ + 9s);
  EXPECT_EQ(counts_.first_image.count(), 1u);
  EXPECT_GE(counts_.first_image.maxMs(), 9000);
}

TEST_P(EveryLoadClient, countsARefusedRequestAndContinues) {
  server_->refuseOne();
  run([&] { return counts_.failed_requests > 0; });
  settle();
  EXPECT_NE(client_->due(), kNever);
  client_->finish(Clock::now());
  EXPECT_EQ(counts_.failed_requests, 1u);
  EXPECT_EQ(counts_.errors, (std::map<ErrorCode, uint64_t>{{ErrorCode::kIo, 1}}));
  EXPECT_EQ(counts_.first_error, "the server says: damaged");
  EXPECT_EQ(counts_.unanswered, 0u);
  EXPECT_GT(counts_.blobs, 2u);
}

TEST_P(EveryLoadClient, countsOpenRequestsWhenTheServerFallsSilent) {
  server_->holdBack(true);
  runUntilRequested(0);
  const core::TimePoint since = Clock::now();
  for (int calls = 1; calls <= 40 && counts_.lost == 0; ++calls) client_->step(since + calls * 1s);
  EXPECT_EQ(counts_.lost, 1u);
  EXPECT_EQ(counts_.failed_requests, server_->openRequests(0));
}

using AFullClient = EveryLoadClient;

TEST_P(AFullClient, timesItsFirstPictureWhenItArrivesNotAtTheNextFrame) {
  plan_.fps = 0.01;
  run([&] { return counts_.first_image.count() > 0; });
  EXPECT_LT(counts_.first_image.maxMs(), 60'000);
}

TEST_P(AFullClient, countsItsWholeTimeAsLookingWhateverTheFrameRate) {
  plan_.fps = 0.01;
  plan_.pixels = 1;
  run([&] { return counts_.converged.count() > 0; });
  const core::TimePoint converged = Clock::now();
  client_->finish(converged + 5s);
  EXPECT_NEAR(counts_.looked_s, std::chrono::duration<double>(converged + 5s - start_).count(), 1e-6);
  EXPECT_GT(counts_.far_off_s, 0);
  EXPECT_LE(counts_.far_off_s, counts_.looked_s - 5);
}

TEST_P(AFullClient, isNotFarOffAtTheFinestLod) {
  run([&] { return counts_.converged.count() > 0; });
  settle();
  client_->step(Clock::now());
  const double far_off_s = counts_.far_off_s;
  client_->finish(Clock::now() + 5s);
  EXPECT_EQ(counts_.far_off_s, far_off_s) << "at the lattice's step, which is more than twice the threshold";
}

INSTANTIATE_TEST_SUITE_P(OfALoadTest, AFullClient, testing::Values(Kind::kFull),
                         [](const auto&) { return "full"; });

INSTANTIATE_TEST_SUITE_P(OfALoadTest, EveryLoadClient, testing::Values(Kind::kFull, Kind::kTrace),
                         [](const auto& kind) { return kind.param == Kind::kFull ? "full" : "trace"; });

/// A model in which all LODs, except the one sent without a request, have fewer triangles than the pages
/// announce.
class AFullClientOfADamagedModel : public EveryLoadClient {
  void prepare(lode::test::SyntheticModel& model) override {
    for (Node& node : model.nodes)
      for (Lod& lod : node.lods) ++lod.triangles;
    --model.nodes.front().lods.back().triangles;
  }
};

TEST_P(AFullClientOfADamagedModel, countsBothTheBrokenConnectionAndTheUndecodableMesh) {
  server_->holdBack(true);
  runUntilRequested(0);
  server_->grantAMeshAndFail(0);
  run([&] { return counts_.lost == 1; });
  EXPECT_EQ(client_->due(), kNever) << "nothing was decoded";
  EXPECT_EQ(counts_.errors,
            (std::map<ErrorCode, uint64_t>{{ErrorCode::kNetwork, 1}, {ErrorCode::kFormat, 1}}));
  EXPECT_EQ(counts_.first_error, "the server says: out of order") << "what came first";
}

TEST_P(AFullClientOfADamagedModel, isFarOffOnceItGaveUp) {
  while (client_->due() != kNever) turn();
  ASSERT_EQ(counts_.first_image.count(), 1u);
  const core::TimePoint noted = Clock::now();
  client_->finish(noted);
  const double far_off_s = counts_.far_off_s;
  plan_.pixels = 10000;  // the resident LODs would suffice for this threshold
  client_->finish(noted + 9s);
  EXPECT_NEAR(counts_.far_off_s, far_off_s + 9, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(OfALoadTest, AFullClientOfADamagedModel, testing::Values(Kind::kFull));

}  // namespace
}  // namespace lode::app
