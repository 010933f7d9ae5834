// Tests with server and client in one process, so that sanitizers see the threads of both. Views change
// during transfers, streams end early, and the server shuts down.

#include "client/stream/streamer.h"

#include <atomic>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "client/app/cli/child_server.h"
#include "client/app/cli/cut_export.h"
#include "client/app/cli/stream_report.h"
#include "common/error.h"
#include "tests/integration/streaming/streaming_fixture.h"
#include "tests/support/own_entries.h"

namespace lode::test {
namespace {

using namespace std::chrono_literals;
using stream::Streamer;
using stream::StreamStatus;

constexpr float kOnlyTheRootPx = 1e6f;  // threshold that the root's coarsest LOD meets

TEST_F(Streaming, convergesForTheLastOfManyViews) {
  Streamer streamer(served_, threads(3));
  const ModelSummary& model = streamer.waitForModel(kPatience);
  std::vector<std::thread> watchers;
  std::atomic<bool> done{false};
  for (int i = 0; i < 2; ++i)
    watchers.emplace_back([&] {
      while (!done) {
        const StreamStatus status = streamer.status();
        EXPECT_TRUE(!status.cut || !status.cut->parts.empty());
        std::this_thread::yield();
      }
    });
  for (int step = 0; step < 200; ++step) {
    streamer.setView(viewAt(step, model), 0.5f);
    if (step % 20 == 0) streamer.waitForCut(kPatience);
  }
  const StreamStatus status = streamer.waitUntilSettled(kPatience);
  done = true;
  for (std::thread& watcher : watchers) watcher.join();
  EXPECT_EQ(status.failure, "");
  ASSERT_TRUE(status.settled && status.cut && status.cut->converged);
  EXPECT_EQ(status.cut->view, viewAt(199, model));

  Streamer fresh(served_, {});
  fresh.waitForModel(kPatience);
  fresh.setView(viewAt(199, model), 0.5f);
  const StreamStatus expected = fresh.waitUntilSettled(kPatience);
  ASSERT_TRUE(expected.cut);
  EXPECT_TRUE(app::weldCut(*status.cut, model.attributes) == app::weldCut(*expected.cut, model.attributes));
}

TEST_F(Streaming, givesManyClientsAtOnceTheSameCut) {
  constexpr size_t kClients = 8;
  std::vector<Mesh> cuts(kClients);
  std::vector<std::thread> clients;
  for (Mesh& cut : cuts)
    clients.emplace_back([&] {
      Streamer streamer(served_, threads(2));
      const ModelSummary& model = streamer.waitForModel(kPatience);
      streamer.setView(viewAt(1, model), 0.5f);
      const StreamStatus status = streamer.waitUntilSettled(kPatience);
      if (status.settled && status.cut) cut = app::weldCut(*status.cut, model.attributes);
    });
  for (std::thread& client : clients) client.join();
  EXPECT_GT(cuts[0].triangles.size(), 100u);
  for (const Mesh& cut : cuts) EXPECT_TRUE(cut == cuts[0]);
}

TEST_F(Streaming, leavesNoThreadAndNoConnectionBehindWheneverItEnds) {
  Streamer(served_, threads(2)).waitForModel(kPatience);  // the server has started all its threads
  const size_t threads_before = ownEntries("task"), descriptors_before = ownEntries("fd");
  for (int step = 0; step < 30; ++step) {
    Streamer streamer(served_, threads(2));
    if (step % 3 == 0) continue;  // end the stream during the connection attempt
    const ModelSummary& model = streamer.waitForModel(kPatience);
    streamer.setView(viewAt(step, model), 0.01f);
    if (step % 3 == 1) {
      EXPECT_TRUE(streamer.waitForCut(kPatience).cut) << step;
    }
  }
  EXPECT_LE(ownEntriesOnceDownTo(threads_before, "task"), threads_before);
  EXPECT_LE(ownEntriesOnceDownTo(descriptors_before, "fd"), descriptors_before);
}

TEST_F(Streaming, freesItsCutsOnItsOwnThread) {
  Streamer streamer(served_, threads(2));
  const ModelSummary& model = streamer.waitForModel(kPatience);
  streamer.setView(viewAt(1, model), 0.5f);
  std::shared_ptr<const core::Cut> cut = streamer.waitUntilSettled(kPatience).cut;
  ASSERT_TRUE(cut);
  for (const float threshold_px : {kOnlyTheRootPx, 0.5f, kOnlyTheRootPx}) {
    streamer.setView(viewAt(1, model), threshold_px);
    ASSERT_NE(streamer.waitUntilSettled(kPatience).cut, cut);
  }
  EXPECT_EQ(cut.use_count(), 2);  // this test and the stream refer to the cut
  const std::weak_ptr<const core::Cut> shown = cut;
  cut.reset();
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!shown.expired() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  EXPECT_TRUE(shown.expired());
}

TEST_F(Streaming, freesKeptCutsOnItsOwnThread) {
  Streamer streamer(served_, threads(2));
  const ModelSummary& model = streamer.waitForModel(kPatience);
  auto cut = std::make_shared<const core::Cut>();
  const std::weak_ptr<const core::Cut> kept = cut;
  streamer.keep({cut});
  EXPECT_EQ(cut.use_count(), 2);
  streamer.setView(viewAt(1, model), 0.5f);
  streamer.waitUntilSettled(kPatience);
  EXPECT_EQ(cut.use_count(), 2);
  cut.reset();
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!kept.expired() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  EXPECT_TRUE(kept.expired());
}

TEST_F(Streaming, continuesWhenTheServerComesBack) {
  Streamer streamer(served_, threads(2));
  const ModelSummary& model = streamer.waitForModel(kPatience);
  streamer.setView(viewAt(1, model), kOnlyTheRootPx);
  ASSERT_TRUE(streamer.waitUntilSettled(kPatience).settled);
  stopServer();
  streamer.setView(viewAt(2, model), 0.1f);
  startServer();
  const StreamStatus status = streamer.waitUntilSettled(kPatience);
  EXPECT_EQ(status.failure, "");
  EXPECT_TRUE(status.settled && status.cut && status.cut->converged);
}

/// For a while, the server does not have the model.
TEST_F(Streaming, awaitsARemovedModelOnlyIfAskedTo) {
  stream::StreamOptions options = threads(2);
  Streamer ends(served_, options);
  options.engine.session.awaits_model = true;
  Streamer awaits(served_, options);
  for (Streamer* streamer : {&ends, &awaits}) {
    streamer->setView(viewAt(1, streamer->waitForModel(kPatience)), kOnlyTheRootPx);
    ASSERT_TRUE(streamer->waitUntilSettled(kPatience).settled);
  }
  stopServer();
  writeModel(folder_ / "b.lode", 1);
  store_ = "b.lode";
  startServer();
  while (awaits.status().trouble.find("has no model 'a'") == std::string::npos)
    ASSERT_FALSE(awaits.waitForNews(kPatience).ended);
  StreamStatus ended = ends.status();
  while (!ended.ended) ended = ends.waitForNews(kPatience);
  EXPECT_NE(ended.failure.find("has no model 'a'"), std::string::npos) << ended.failure;
  EXPECT_TRUE(awaits.status().cut);
  stopServer();
  store_ = "a.lode";
  startServer();
  awaits.setView(viewAt(2, *awaits.model()), 0.1f);
  const StreamStatus status = awaits.waitUntilSettled(kPatience);
  EXPECT_EQ(status.failure, "");
  EXPECT_TRUE(status.settled && status.cut && status.cut->converged);
}

TEST_F(Streaming, convergesOnTheNewBuildOfAReplacedModelWithoutAHole) {
  Streamer streamer(served_, threads(2));
  const ModelSummary model = streamer.waitForModel(kPatience);
  streamer.setView(viewAt(1, model), 0.5f);
  const StreamStatus before = streamer.waitUntilSettled(kPatience);
  ASSERT_TRUE(before.settled);
  replaceModel(2);
  StreamStatus status;
  while (!(status.settled && status.cut_build != before.cut_build) && status.failure.empty()) {
    status = streamer.waitForNews(kPatience);
    ASSERT_TRUE(status.cut);
    for (const core::LeftOut& place : status.cut->left_out)
      EXPECT_FALSE(core::boxMayBeVisible(place.box, status.cut->view)) << "a hole";
  }
  EXPECT_EQ(status.failure, "");
  EXPECT_TRUE(status.cut->converged);

  Streamer fresh(served_, {});
  fresh.waitForModel(kPatience);
  fresh.setView(viewAt(1, model), 0.5f);
  const StreamStatus expected = fresh.waitUntilSettled(kPatience);
  EXPECT_EQ(status.cut_build, expected.cut_build);
  EXPECT_TRUE(app::weldCut(*status.cut, model.attributes) == app::weldCut(*expected.cut, model.attributes));
}

TEST_F(Streaming, keepsItsCutAndSaysWhyWhenTheServerGoes) {
  Streamer streamer(served_, {});
  const ModelSummary& model = streamer.waitForModel(kPatience);
  streamer.setView(viewAt(1, model), kOnlyTheRootPx);
  const StreamStatus before = streamer.waitUntilSettled(kPatience);
  ASSERT_TRUE(before.settled && before.cut);
  stopServer();
  streamer.setView(viewAt(2, model), 0.001f);
  const StreamStatus status = streamer.waitUntilSettled(1s);
  EXPECT_FALSE(status.settled);
  EXPECT_FALSE(status.ended) << status.failure;
  EXPECT_NE(status.trouble, "");
  ASSERT_TRUE(status.cut);
  EXPECT_FALSE(status.cut->converged);
  EXPECT_EQ(status.cut->triangles, before.cut->triangles);
}

TEST_F(Streaming, convergesWithoutAServerIfAllMeshesAreResident) {
  Streamer streamer(served_, {});
  const ModelSummary& model = streamer.waitForModel(kPatience);
  streamer.setView(viewAt(1, model), 5);
  ASSERT_TRUE(streamer.waitUntilSettled(kPatience).settled);
  stopServer();
  streamer.setView(viewAt(1, model), kOnlyTheRootPx);
  const StreamStatus status = streamer.waitUntilSettled(kPatience);
  EXPECT_EQ(status.failure, "");
  EXPECT_TRUE(status.settled && status.cut && status.cut->converged);
}

TEST_F(Streaming, neverTakesTheCutOfAnEarlierViewForAConvergedOne) {
  Streamer streamer(served_, {});
  const ModelSummary& model = streamer.waitForModel(kPatience);
  streamer.setView(viewAt(1, model), kOnlyTheRootPx);
  ASSERT_TRUE(app::hasConverged(streamer.waitForConvergence(kPatience)));
  stopServer();
  for (int step = 2; step < 50; ++step) {  // no wait is long enough to refine for the new view
    streamer.setView(viewAt(step, model), 0.001f);
    EXPECT_FALSE(app::hasConverged(streamer.waitForConvergence(0ms))) << "step " << step;
  }
}

TEST_F(Streaming, wakesWaitersForNewsOnlyUntilItHasSettled) {
  Streamer streamer(served_, {});
  while (!streamer.model()) streamer.waitForNews(kPatience);
  streamer.setView(viewAt(1, *streamer.model()), 0.5f);
  StreamStatus status = streamer.waitForNews(kPatience);
  for (int news = 0; news < 10'000 && !(status.current && status.settled); ++news)
    status = streamer.waitForNews(kPatience);
  EXPECT_TRUE(status.current && status.settled);
  const auto begin = std::chrono::steady_clock::now();
  streamer.waitForNews(1200ms);  // longer than the tick of the stream's thread
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 1200ms);
}

TEST_F(Streaming, waitsForRoomWhereTheServerIsFull) {
  stopServer();
  max_connections_ = 1;
  startServer();
  std::optional<Streamer> first(std::in_place, served_, threads(1));
  first->waitForModel(kPatience);
  Streamer second(served_, threads(1));
  StreamStatus status;
  while (status.trouble.empty() && !status.ended) status = second.waitForNews(kPatience);
  EXPECT_FALSE(status.ended) << status.failure;
  EXPECT_NE(status.trouble.find("the server says"), std::string::npos) << status.trouble;
  first.reset();
  EXPECT_EQ(second.waitForModel(kPatience).name, "a");
}

TEST_F(Streaming, needsTheTokenOfAChildServer) {
  const app::ChildServer child(folder_ / "a.lode");
  stream::StreamOptions options = threads(1);
  options.engine.session.token = child.token();
  EXPECT_EQ(Streamer(child.served(), options).waitForModel(kPatience).name, "a");
  EXPECT_NE(app::ChildServer(folder_ / "a.lode").token(), child.token());
  options.engine.session.token.clear();
  Streamer stranger(child.served(), options);
  EXPECT_THROW(stranger.waitForModel(kPatience), Error);
}

TEST_F(Streaming, reportsANetworkErrorIfNoServerListens) {
  stopServer();
  Streamer streamer(served_, {});
  try {
    streamer.waitForModel(kPatience);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNetwork);
  }
  EXPECT_TRUE(streamer.status().ended);
}

}  // namespace
}  // namespace lode::test
