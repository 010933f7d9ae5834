#include <deque>
#include <random>

#include <gtest/gtest.h>

#include "client/core/engine.h"
#include "common/error.h"
#include "tests/unit/core/scripted_server.h"

namespace lode::core {
namespace {

using namespace test;
using std::chrono::milliseconds;

/// An engine and a server with a slow link between them, on a clock that only the test moves.
class World {
 public:
  World(uint32_t seed, uint64_t memory_budget_bytes)
      : random_(seed), model_({seed, 4}), server_(model_), engine_(options(seed, memory_budget_bytes)) {}

  /// A step of the clock: bytes that are due arrive, some decoding ends, the engine is stepped.
  void step(milliseconds time) {
    now_ += time;
    if (engine_.wantsConnection(now_)) {
      to_server_.clear();
      to_client_.clear();
      server_.accept();
      engine_.connect(now_);
    }
    deliver(to_server_, [this](const Bytes& bytes) { server_.receive(bytes); });
    post(to_client_, server_.give(random_() % 4));
    deliver(to_client_, [this](const Bytes& bytes) { engine_.receive(bytes, now_); });
    for (DecodeJob& job : engine_.takeDecodeJobs()) decoding_.push_back(std::move(job));
    for (size_t some = 1 + random_() % 4; some > 0 && !decoding_.empty(); --some) {
      const DecodeJob& job = decoding_.front();
      engine_.finishDecode({job.blob, job.use, model_.mesh(job.use.mesh), nullptr, nullptr, ""});
      decoding_.pop_front();
    }
    engine_.step(now_);
    post(to_server_, engine_.takeOutgoing());
    check();
  }

  /// The connection breaks; what is under way is lost when the next one begins.
  void breakConnection() {
    if (!engine_.connected() || !engine_.cut()) return;
    engine_.disconnect(Error(ErrorCode::kNetwork, "broken"), now_);
  }

  /// Looks from a place around or within the model.
  View randomView() {
    const double side = SyntheticModel::boxSide();
    const auto number = [this] { return std::uniform_real_distribution<double>(-1, 1)(random_); };
    View view;
    const double reach = random_() % 2 == 0 ? 0.6 : 3;
    view.eye_model = glm::dvec3(side / 2) + side * reach * glm::dvec3(number(), number(), number());
    view.forward = glm::normalize(glm::dvec3(side / 2) - view.eye_model + side * 0.1);
    view.up = glm::normalize(glm::cross(view.forward, glm::dvec3(0.3, 0.9, 0.1)));
    return view;
  }

  uint32_t random() { return static_cast<uint32_t>(random_()); }
  Engine& engine() { return engine_; }
  const ScriptedServer& server() const { return server_; }
  size_t decoding() const { return decoding_.size(); }

 private:
  struct Parcel {
    TimePoint due;
    Bytes bytes;
  };

  static EngineOptions options(uint32_t seed, uint64_t memory_budget_bytes) {
    EngineOptions options;
    options.jitter_seed = seed;
    options.session.model = "model";
    options.session.max_wished_bytes = 20'000;
    options.memory_budget_bytes = memory_budget_bytes;
    return options;
  }

  void post(std::deque<Parcel>& line, Bytes bytes) {
    if (bytes.empty()) return;
    const TimePoint due = now_ + milliseconds(random_() % 60);
    line.push_back({line.empty() ? due : std::max(due, line.back().due), std::move(bytes)});
  }

  template <typename Take>
  void deliver(std::deque<Parcel>& line, Take&& take) {
    for (; !line.empty() && line.front().due <= now_; line.pop_front()) take(line.front().bytes);
  }

  /// The cut covers the model exactly once.
  void check() const {
    if (!engine_.cut()) return;
    std::set<NodeKey> shown;
    for (const CutPart& part : engine_.cut()->parts) {
      ASSERT_TRUE(part.mesh);
      ASSERT_TRUE(shown.insert(part.node).second) << "node " << part.node.value << " is shown twice";
    }
    for (const NodeKey leaf : model_.leaves()) {
      unsigned covered = 0;
      for (NodeKey key = leaf;; key = key.parent()) {
        covered += static_cast<unsigned>(shown.count(key));
        if (key == kRootKey) break;
      }
      ASSERT_EQ(covered, 1u) << "leaf " << leaf.value;
    }
  }

  std::mt19937 random_;
  TimePoint now_{};
  SyntheticModel model_;
  ScriptedServer server_;
  Engine engine_;
  std::deque<Parcel> to_server_, to_client_;
  std::deque<DecodeJob> decoding_;
};

class EngineProperties : public testing::TestWithParam<uint32_t> {};

/// Whatever the camera has done, a view that stays converges.
void convergeFor(World& world, const View& view) {
  world.engine().setView(view, 1);
  for (int steps = 0; steps < 20'000 && !world.engine().settled(); ++steps) world.step(milliseconds(10));
  EXPECT_TRUE(world.engine().settled())
      << world.server().openWishes() << " wishes at the server, " << world.decoding() << " decoding";
  EXPECT_TRUE(world.engine().failure().empty()) << world.engine().failure();
}

TEST_P(EngineProperties, turningBackWithinARoundTripNeverFreezesTheStream) {
  World world(GetParam(), 1ull << 30);
  for (int step = 0; step < 60; ++step) world.step(milliseconds(10));
  const View one = world.randomView(), other = world.randomView();
  for (int turn = 0; turn < 20; ++turn) {
    world.engine().setView(turn % 2 == 0 ? one : other, 1);
    for (uint32_t some = world.random() % 6; some > 0; --some) world.step(milliseconds(5));
  }
  convergeFor(world, one);
}

TEST_P(EngineProperties, turningAwayAndBackAtOnceNeverFreezesTheStream) {
  World world(GetParam(), 1ull << 30);
  View away;
  away.eye_model = glm::dvec3(1e7);
  for (int turn = 0; turn < 8; ++turn) {
    convergeFor(world, away);
    const View near = world.randomView();
    world.engine().setView(near, 1);
    for (uint32_t some = 1 + world.random() % 12; some > 0; --some) world.step(milliseconds(10));
    world.engine().setView(away, 1);
    world.step(milliseconds(1));
    convergeFor(world, near);
  }
}

TEST_P(EngineProperties, convergesHoweverOftenTheConnectionBreaks) {
  World world(GetParam(), 1ull << 30);
  for (int place = 0; place < 10; ++place) {
    world.engine().setView(world.randomView(), 1);
    for (uint32_t some = world.random() % 60; some > 0; --some) world.step(milliseconds(10));
    world.breakConnection();
    world.step(milliseconds(10));
  }
  convergeFor(world, world.randomView());
  EXPECT_EQ(world.engine().trouble(), "");
}

TEST_P(EngineProperties, wanderingCamerasAlwaysSeeAWholePictureAndConvergeWhereTheyStay) {
  World world(GetParam(), 1ull << 30);
  for (int place = 0; place < 12; ++place) {
    for (int step = 0; step < 8; ++step) {
      world.engine().setView(world.randomView(), 1);
      world.step(milliseconds(1 + world.random() % 20));
    }
    convergeFor(world, world.randomView());
  }
  for (const auto& [blob, times] : world.server().completed())
    EXPECT_EQ(times, 1u) << "blob " << blob << " was fetched again without an eviction between";
}

INSTANTIATE_TEST_SUITE_P(Seeds, EngineProperties, testing::Range(1u, 13u));

}  // namespace
}  // namespace lode::core
