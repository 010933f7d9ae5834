#include <algorithm>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "client/core/engine.h"
#include "tests/unit/core/scripted_server.h"

namespace lode::core {
namespace {

using namespace fixture;

/// Runs engines with one cache against one server.
class CachedEngine : public testing::Test {
 protected:
  static EngineOptions options() {
    EngineOptions options;
    options.session.model = "model";
    options.has_cache = true;
    return options;
  }

  /// Returns options for a second run after an engine.
  static EngineOptions optionsAfter(const Engine& first) {
    EngineOptions again = options();
    again.cached_model = *first.summary();
    return again;
  }

  static View near(const glm::dvec3& forward = View().forward) {
    View view;
    view.eye_model = glm::dvec3(SyntheticModel::boxSide() / 2);
    view.forward = forward;
    return view;
  }

  /// Steps an engine until it has settled or makes no progress.
  void run(Engine& engine, const View& view = near()) {
    engine.setView(view, 1);
    engine.step(kStart);
    for (int steps = 0; steps < 5000 && !engine.settled() && !engine.exhausted(); ++steps) {
      if (engine.wantsConnection(kStart)) {
        server_.accept();
        engine.connect(kStart);
      }
      engine.receive(server_.give(4), kStart);
      std::ranges::move(engine.takeCacheQueries(), std::back_inserter(queries_));
      if (answers_late_) std::shuffle(queries_.begin(), queries_.end(), random_);
      const size_t answers = answers_late_ ? random_() % 4 : queries_.size();
      for (size_t i = 0; i < answers && !queries_.empty(); ++i) {
        const auto found = cache_.find(queries_.back().digest);
        engine.finishCacheQuery(queries_.back(),
                                found == cache_.end() ? std::nullopt : std::optional(found->second));
        queries_.pop_back();
      }
      for (const DecodeJob& job : engine.takeDecodeJobs())
        engine.finishDecode({job.blob, job.use, model_.mesh(job.use.mesh), nullptr, nullptr, ""});
      engine.step(kStart);
      server_.receive(engine.takeOutgoing());
      if (!takes_arrivals_) continue;
      for (Engine::Arrival& arrival : engine.takeArrivals())
        cache_[arrival.blob.digest] = std::move(arrival.bytes);
    }
  }

  std::map<Digest, Bytes> cache_;
  std::vector<BlobRef> queries_;  ///< queries without an answer
  bool answers_late_ = false;     ///< if true, the cache answers a few queries at a time, in random order
  bool takes_arrivals_ = true;
  std::mt19937 random_{5};
  SyntheticModel model_{{7, 4}};
  ScriptedServer server_{model_};
};

TEST_F(CachedEngine, receivesNoBlobOnASecondVisit) {
  Engine first(options());
  run(first);
  ASSERT_TRUE(first.settled());
  EXPECT_EQ(first.counts().cache_bytes, 0u);
  uint64_t kept_bytes = 0;
  for (const auto& [name, bytes] : cache_) kept_bytes += bytes.size();
  const auto sent = server_.completed();
  Engine second(optionsAfter(first));
  run(second);
  ASSERT_TRUE(second.settled());
  EXPECT_EQ(second.cut()->triangles, first.cut()->triangles);
  EXPECT_EQ(server_.completed(), sent);
  EXPECT_LT(second.counts().received_bytes, 500u);
  EXPECT_GT(second.counts().cache_bytes, 0u);
  EXPECT_LE(second.counts().cache_bytes, kept_bytes);  // stand-ins are not needed again
}

TEST_F(CachedEngine, receivesNoBlobOnASecondVisitEvenIfTheCacheIsSlow) {
  answers_late_ = true;
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    random_.seed(seed);
    cache_.clear();
    Engine first(options());
    run(first);
    ASSERT_TRUE(first.settled());
    const auto sent = server_.completed();
    Engine second(optionsAfter(first));
    run(second);
    ASSERT_TRUE(second.settled());
    EXPECT_EQ(second.cut()->triangles, first.cut()->triangles);
    EXPECT_EQ(server_.completed(), sent) << "seed " << seed;
  }
}

TEST_F(CachedEngine, fetchesBlobsThatTheCacheLostAndKeepsThemAgain) {
  Engine first(options());
  run(first);
  for (auto blob = cache_.begin(); blob != cache_.end();) {
    blob = cache_.erase(blob);
    if (blob != cache_.end()) ++blob;
  }
  Engine second(optionsAfter(first));
  run(second);
  EXPECT_TRUE(second.settled());
  const auto sent = server_.completed();
  Engine third(optionsAfter(second));
  run(third);
  EXPECT_TRUE(third.settled());
  EXPECT_EQ(third.cut()->triangles, first.cut()->triangles);
  EXPECT_EQ(server_.completed(), sent);
}

TEST_F(CachedEngine, showsCachedBlobsOffline) {
  Engine first(options());
  run(first);
  EngineOptions offline = optionsAfter(first);
  offline.offline = true;
  Engine whole(offline);
  run(whole);
  EXPECT_TRUE(whole.settled());
  EXPECT_EQ(whole.cut()->triangles, first.cut()->triangles);
  EXPECT_EQ(whole.counts().received_bytes, 0u);

  const Node& root = server_.nodes().at(kRootKey);
  std::map<Digest, Bytes> few;
  for (const BlobRef& blob : {first.summary()->root_page, root.lods.back().payload})
    few[blob.digest] = cache_.at(blob.digest);
  cache_ = few;
  Engine part(offline);
  run(part);
  EXPECT_TRUE(part.exhausted());
  EXPECT_FALSE(part.settled());
  ASSERT_TRUE(part.cut());
  EXPECT_EQ(part.cut()->parts.size(), 1u);
}

TEST_F(CachedEngine, keepsNoMoreArrivalsThanTheLimit) {
  model_ = SyntheticModel({.seed = 33, .payload_bytes_a_triangle = 2500});
  server_ = ScriptedServer(model_);
  takes_arrivals_ = false;
  Engine engine(options());
  for (const glm::dvec3& forward : {glm::dvec3(0, 0, -1), {1, 0, 0}, {0, 0, 1}, {-1, 0, 0}})
    run(engine, near(forward));
  ASSERT_GT(engine.counts().received_bytes, kMaxArrivalBytes * 5 / 4);
  uint64_t bytes = 0;
  for (const Engine::Arrival& arrival : engine.takeArrivals()) bytes += arrival.bytes.size();
  EXPECT_GT(bytes, kMaxArrivalBytes / 2);
  EXPECT_LE(bytes, kMaxArrivalBytes);
}

TEST_F(CachedEngine, opensAnotherBuildOfTheServerDespiteACachedSummary) {
  EngineOptions stale = options();
  stale.cached_model = server_.summary();
  stale.cached_model->build_id.bytes[5] ^= std::byte{1};
  Engine engine(stale);
  run(engine);
  EXPECT_TRUE(engine.settled());
  EXPECT_EQ(engine.summary()->build_id, server_.summary().build_id);
}

}  // namespace
}  // namespace lode::core
