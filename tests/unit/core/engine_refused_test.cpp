#include <gtest/gtest.h>

#include "client/core/engine.h"
#include "common/error.h"
#include "tests/unit/core/scripted_client.h"
#include "tests/unit/core/scripted_server.h"

namespace lode::core {
namespace {

using namespace fixture;

/// An engine with a cut, whose server has been unreachable for a moment.
class RefusedEngine : public testing::Test {
 protected:
  /// @param awaits_model  see SessionOptions
  void loseServer(bool awaits_model) {
    EngineOptions options;
    options.session.model = "model";
    options.session.awaits_model = awaits_model;
    engine_.emplace(std::move(options));
    engine_->setView(farView(), 1000);
    connect();
    for (const DecodeJob& job : engine_->takeDecodeJobs())
      engine_->finishDecode({job.blob, job.use, model_.mesh(job.use.mesh), nullptr, nullptr, ""});
    engine_->step(now_);
    ASSERT_TRUE(engine_->cut());
    engine_->disconnect(Error(ErrorCode::kNetwork, "closed"), now_);
  }

  /// Reconnects as soon as the engine is due.
  void connect() {
    while (!engine_->wantsConnection(now_)) now_ += std::chrono::milliseconds(10);
    server_.accept();
    engine_->connect(now_);
    server_.receive(engine_->takeOutgoing());
    engine_->receive(server_.give(100), now_);
    engine_->step(now_);
  }

  SyntheticModel model_{{.seed = 1, .depth = 2}};
  ScriptedServer server_{model_};
  TimePoint now_ = kStart;
  std::optional<Engine> engine_;
};

TEST_F(RefusedEngine, keepsThePictureAndRetriesWithGrowingPausesUntilTheModelIsBack) {
  loseServer(true);
  server_.offer(false);
  connect();
  const TimePoint first = now_;
  connect();
  const TimePoint second = now_;
  for (int i = 0; i < 4; ++i) connect();
  const TimePoint before_last = now_;
  connect();
  EXPECT_GT(now_ - before_last, 4 * (second - first));
  EXPECT_EQ(engine_->trouble(), "the server says: no model");
  EXPECT_EQ(engine_->troubleRemedy(), Remedy::kModel);
  EXPECT_EQ(engine_->failure(), "");
  EXPECT_TRUE(engine_->cut());
  server_.offer(true);
  connect();
  EXPECT_EQ(engine_->trouble(), "");
  EXPECT_EQ(engine_->troubleRemedy(), Remedy::kNone);
  EXPECT_TRUE(engine_->staysConnected());
}

TEST_F(RefusedEngine, endsUnlessItAwaitsTheModel) {
  loseServer(false);
  server_.offer(false);
  EXPECT_THROW(connect(), Error);
}

TEST_F(RefusedEngine, endsIfItNeverHadTheModel) {
  EngineOptions options;
  options.session.model = "model";
  options.session.awaits_model = true;
  engine_.emplace(std::move(options));
  server_.offer(false);
  EXPECT_THROW(connect(), Error);
}

}  // namespace
}  // namespace lode::core
