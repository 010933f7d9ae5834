#include <deque>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "client/core/engine.h"
#include "client/core/lod/cut.h"
#include "common/error.h"
#include "tests/support/seeds.h"
#include "tests/unit/core/scripted_server.h"

namespace lode::core {
namespace {

using namespace fixture;
using std::chrono::milliseconds;

/// An engine and a server with a slow link between them, on a simulated clock.
class World {
 public:
  World(uint32_t seed, uint64_t memory_budget_bytes, uint32_t payload_bytes_a_triangle = 1,
        uint64_t drawn_budget_bytes = std::numeric_limits<uint64_t>::max())
      : random_(seed),
        cameras_(seed),
        memory_budget_bytes_(memory_budget_bytes),
        drawn_budget_bytes_(drawn_budget_bytes),
        models_{
            SyntheticModel({.seed = seed, .depth = 4, .payload_bytes_a_triangle = payload_bytes_a_triangle})},
        server_(models_.front()),
        engine_(options(seed, memory_budget_bytes, drawn_budget_bytes)) {}

  /// Advances the clock: due bytes arrive, some decoding ends, and the engine steps.
  void step(milliseconds time) {
    now_ += time;
    if (engine_.wantsConnection(now_)) {
      to_server_.clear();
      to_client_.clear();
      server_.accept();
      engine_.connect(now_);
    }
    deliver(to_server_, [this](const Bytes& bytes) { server_.receive(bytes); });
    postCut(to_client_, server_.give(random_() % 4));
    deliver(to_client_, [this](const Bytes& bytes) { engine_.receive(bytes, now_); });
    for (DecodeJob& job : engine_.takeDecodeJobs())
      decoding_.push_back({job.blob, job.use, meshOf(job), nullptr, nullptr, ""});
    for (size_t some = 1 + random_() % 4; some > 0 && !decoding_.empty(); --some) {
      engine_.finishDecode(std::move(decoding_.front()));
      decoding_.pop_front();
    }
    engine_.step(now_);
    post(to_server_, engine_.takeOutgoing());
    check();
  }

  /// Breaks the connection; bytes in transit are lost when the next one starts.
  void breakConnection() {
    if (!engine_.connected() || !engine_.cut()) return;
    engine_.disconnect(Error(ErrorCode::kNetwork, "broken"), now_);
  }

  /// Replaces the model by another build.
  void replaceModel() {
    models_.push_back(SyntheticModel({static_cast<uint32_t>(random_()), 4}));
    server_.replaceBy(models_.back());
  }

  /// Returns true if the engine has everything that the view needs and the server has.
  bool settled() const {
    return engine_.settled() && engine_.summary()->build_id == server_.summary().build_id;
  }

  /// Sets a random view around or inside the model.
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

  static EngineOptions options(uint32_t seed, uint64_t memory_budget_bytes, uint64_t drawn_budget_bytes) {
    EngineOptions options;
    options.jitter_seed = seed;
    options.session.model = "model";
    if (memory_budget_bytes >= 1u << 30) options.session.max_requested_bytes = 20'000;
    options.prefetch = true;
    options.memory_budget_bytes = memory_budget_bytes;
    options.refine.drawn_budget_bytes = drawn_budget_bytes;
    return options;
  }

  void post(std::deque<Parcel>& line, Bytes bytes) {
    if (bytes.empty()) return;
    const TimePoint due = now_ + milliseconds(random_() % 60);
    line.push_back({line.empty() ? due : std::max(due, line.back().due), std::move(bytes)});
  }

  /// The two ends may notice a broken connection at different times.
  void postCut(std::deque<Parcel>& line, const Bytes& bytes) {
    const auto cut = bytes.begin() + static_cast<std::ptrdiff_t>(random_() % (bytes.size() + 1));
    post(line, {bytes.begin(), cut});
    post(line, {cut, bytes.end()});
  }

  template <typename Take>
  void deliver(std::deque<Parcel>& line, Take&& take) {
    for (; !line.empty() && line.front().due <= now_; line.pop_front()) take(line.front().bytes);
  }

  /// Returns the build of a job: the last one whose payload has its digest.
  std::shared_ptr<const Mesh> meshOf(const DecodeJob& job) const {
    for (auto model = models_.rbegin(); model != models_.rend(); ++model) {
      const auto node = model->nodes().find(job.use.mesh.node);
      if (node != model->nodes().end() && job.use.mesh.lod < node->second.lods.size() &&
          node->second.lods[job.use.mesh.lod].triangles == job.expected.triangles)
        return model->mesh(job.use.mesh);
    }
    return nullptr;
  }

  /// Expects that the cut covers the region near its view exactly once, and the whole model once it has
  /// settled, and that shownParts() covers what any other camera sees: with the newest build or, before it is
  /// resident, an older one. Only for a single view; the tests of ViewCuts check several.
  void check() {
    expectWithinBudget();
    if (!engine_.cut() || engine_.viewCuts()->cuts.size() > 1) return;
    const Cut& cut = *engine_.cut();
    EXPECT_LE(cut.drawn_bytes, drawn_budget_bytes_);
    std::vector<uint32_t> all(cut.parts.size());
    std::iota(all.begin(), all.end(), 0u);
    expectCovered(all, [&](const ModelBox& box) {
      return engine_.settled() || boxMayBeVisible(box, cut.view, kMarginWidening);
    });
    for (int camera = 0; camera < 2; ++camera) {
      const View view = anyView();
      expectCovered(shownParts(cut, view), [&](const ModelBox& box) { return boxMayBeVisible(box, view); });
    }
  }

  /// Returns a view at a random position with a random direction.
  View anyView() {
    const auto number = [this] { return std::uniform_real_distribution<double>(-1, 1)(cameras_); };
    const auto vector = [&] { return glm::dvec3(number(), number(), number()); };
    View view;
    view.eye_model = SyntheticModel::boxSide() * (0.5 + (cameras_() % 2 == 0 ? 0.5 : 2.0) * vector());
    view.forward = glm::normalize(vector());
    view.up = glm::normalize(glm::cross(view.forward, vector()));
    view.fov_y_rad = 0.8 + 0.7 * number();
    return view;
  }

  /// @param isDue  returns true if a node must be covered.
  template <typename IsDue>
  void expectCovered(std::span<const uint32_t> shown, IsDue&& isDue) const {
    std::string problem;
    for (auto model = models_.rbegin(); model != models_.rend(); ++model)
      if (problem = problemWith(*model, shown, isDue); problem.empty()) return;
    ASSERT_EQ(problem, "");
  }

  /// Expects that all memory shares hold. Exceptions: the hierarchy may exceed its share by one requested
  /// page, and a blob larger than the transit share is requested and decoded alone.
  void expectWithinBudget() const {
    const EngineCounts counts = engine_.counts();
    const uint64_t share = memory_budget_bytes_ / kTransitBudgetShare;
    EXPECT_LE(counts.resident_bytes,
              memory_budget_bytes_ - memory_budget_bytes_ / kHierarchyBudgetShare - 2 * share);
    EXPECT_LE(counts.transit_bytes, 2 * share + largestBlobBytes());
  }

  uint64_t largestBlobBytes() const {
    uint64_t largest = 0;
    for (const SyntheticModel& model : models_)
      for (const auto& [key, node] : model.nodes())
        for (const Lod& lod : node.lods)
          largest = std::max(largest, lod.payload.bytes + 2 * meshBytes(lod.vertices, lod.triangles,
                                                                        SyntheticModel::attributes()));
    return largest;
  }

  template <typename IsDue>
  std::string problemWith(const SyntheticModel& model, std::span<const uint32_t> numbers,
                          IsDue&& isDue) const {
    std::set<NodeKey> shown;
    for (const uint32_t number : numbers) {
      const CutPart& part = partOf(*engine_.cut(), number);
      if (!part.mesh) return "node " + std::to_string(part.node.value) + " has no mesh";
      if (!model.nodes().contains(part.node)) return "a node of another build";
      if (!shown.insert(part.node).second)
        return "node " + std::to_string(part.node.value) + " is shown twice";
    }
    for (const NodeKey leaf : model.leaves()) {
      unsigned covered = 0;
      for (NodeKey key = leaf;; key = key.parent()) {
        covered += static_cast<unsigned>(shown.count(key));
        if (key == kRootKey) break;
      }
      const ModelBox box = toModelBox(model.nodes().at(leaf).box, SyntheticModel::lattice().step);
      if (covered > 1 || (covered == 0 && isDue(box)))
        return "leaf " + std::to_string(leaf.value) + " is covered " + std::to_string(covered) + " times";
    }
    return "";
  }

  std::mt19937 random_, cameras_;
  TimePoint now_{};
  const uint64_t memory_budget_bytes_, drawn_budget_bytes_;
  std::deque<SyntheticModel> models_;  // builds, the newest last
  ScriptedServer server_;
  Engine engine_;
  std::deque<Parcel> to_server_, to_client_;
  std::deque<DecodeResult> decoding_;
};

class EngineProperties : public testing::TestWithParam<uint32_t> {};

/// Expects that the cut of an unchanged view converges.
void convergeFor(World& world, const View& view) {
  world.engine().setView(view, 1);
  for (int steps = 0; steps < 20'000 && !world.settled(); ++steps) world.step(milliseconds(10));
  EXPECT_TRUE(world.settled()) << world.server().openRequests() << " requests at the server, "
                               << world.decoding() << " decoding";
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

TEST_P(EngineProperties, staysWithinATenthOfTheWantedMemoryAndSettles) {
  World unlimited(GetParam(), 1ull << 30);
  const View near = unlimited.randomView();
  convergeFor(unlimited, near);
  const uint64_t liked_bytes = unlimited.engine().counts().resident_bytes;
  World world(GetParam(), liked_bytes / 10);
  for (int place = 0; place < 12; ++place) {
    for (uint32_t some = world.random() % 40; some > 0; --some) {
      world.engine().setView(world.randomView(), 1);
      world.step(milliseconds(1 + world.random() % 20));
    }
    convergeFor(world, place == 11 ? near : world.randomView());
  }
  EXPECT_TRUE(world.engine().limited());
  EXPECT_FALSE(world.engine().cut()->converged);
  const auto waited = [&] { return world.engine().counts().waited.of(Waiting::kBudget); };
  const auto before = waited();
  world.step(milliseconds(10));
  EXPECT_EQ(waited() - before, milliseconds(10));
}

TEST_P(EngineProperties, staysWithinTheDrawnBudgetAndSettles) {
  World unlimited(GetParam(), 1ull << 30);
  const View near = unlimited.randomView();
  convergeFor(unlimited, near);
  const uint64_t liked_bytes = unlimited.engine().cut()->drawn_bytes;
  World world(GetParam(), 1ull << 30, 1, liked_bytes / 2);
  for (int place = 0; place < 12; ++place) {
    for (uint32_t some = world.random() % 40; some > 0; --some) {
      world.engine().setView(world.randomView(), 1);
      world.step(milliseconds(1 + world.random() % 20));
    }
    convergeFor(world, place == 11 ? near : world.randomView());
  }
  EXPECT_TRUE(world.engine().limited());
}

TEST_P(EngineProperties, limitsOpenRequestsToTheirMemoryShareAndConverges) {
  constexpr uint32_t kHeavy = 64;  // payloads larger than their meshes
  World unlimited(GetParam(), 1ull << 30, kHeavy);
  convergeFor(unlimited, unlimited.randomView());
  World world(GetParam(), 4 * unlimited.engine().counts().resident_bytes, kHeavy);
  for (int place = 0; place < 6; ++place) convergeFor(world, world.randomView());
}

TEST_P(EngineProperties, convergesOnTheNewestBuildHoweverOftenTheModelIsReplaced) {
  World world(GetParam(), 1ull << 30);
  for (int place = 0; place < 8; ++place) {
    world.engine().setView(world.randomView(), 1);
    for (uint32_t some = world.random() % 80; some > 0; --some) world.step(milliseconds(10));
    if (world.random() % 3 == 0) world.breakConnection();
    if (world.engine().connected() && world.engine().cut()) world.replaceModel();
    for (uint32_t some = world.random() % 20; some > 0; --some) world.step(milliseconds(10));
  }
  convergeFor(world, world.randomView());
  EXPECT_TRUE(world.engine().cut()->converged);
}

/// Returns a view moving towards the centre of the model and past it.
View flight(const View& from, int step) {
  View view = from;
  view.eye_model += view.forward * (SyntheticModel::boxSide() * 2e-3 * step);
  return view;
}

TEST_P(EngineProperties, prefetchesForAMovingCameraWithoutFetchingABlobTwice) {
  World world(GetParam(), 1ull << 30);
  const View from = world.randomView();
  convergeFor(world, from);
  for (int step = 0; step < 300; ++step) {
    world.engine().setView(flight(from, step), 1);
    world.step(milliseconds(10));
  }
  const PrefetchCounts counts = world.engine().counts().prefetch;
  EXPECT_LE(counts.used + counts.unused, counts.requested);
  EXPECT_EQ(counts.unused == 0, counts.unused_bytes == 0);
  convergeFor(world, flight(from, 300));
  for (const auto& [blob, times] : world.server().completed()) EXPECT_EQ(times, 1u) << blob;
}

TEST(Engine, prefetchesForAnyMovingInstanceOfAModel) {
  uint64_t requested = 0;
  for (uint32_t seed = 1; seed < 7; ++seed) {
    World world(seed, 1ull << 30);
    const View from = world.randomView();
    View resting = from;
    resting.eye_model -= from.forward * (100 * SyntheticModel::boxSide());
    const auto look = [&](int step) {
      world.engine().setViews(std::vector{resting, flight(from, step)}, 1);
      world.step(milliseconds(10));
    };
    for (int step = 0; step < 1000; ++step) look(0);
    for (int step = 0; step < 300; ++step) look(step);
    requested += world.engine().counts().prefetch.requested;
  }
  EXPECT_GT(requested, 0u);
}

TEST(Engine, prefetchesEvenIfTheFinestLodMissesTheThreshold) {
  uint64_t requested = 0;
  for (uint32_t seed = 1; seed < 7; ++seed) {
    World world(seed, 1ull << 30);
    constexpr float kThresholdPx = 1e-3f;
    const View from = world.randomView();
    for (int step = 0; step < 1000; ++step) {
      world.engine().setView(from, kThresholdPx);
      world.step(milliseconds(10));
    }
    if (!world.engine().cut() || world.engine().cut()->max_error_px <= 2 * kThresholdPx) continue;
    for (int step = 0; step < 300; ++step) {
      world.engine().setView(flight(from, step), kThresholdPx);
      world.step(milliseconds(10));
    }
    requested += world.engine().counts().prefetch.requested;
  }
  EXPECT_GT(requested, 0u);
}

TEST_P(EngineProperties, prefetchesNothingForAStandingCamera) {
  World world(GetParam(), 1ull << 30);
  convergeFor(world, world.randomView());
  convergeFor(world, world.randomView());  // the camera jumps
  EXPECT_EQ(world.engine().counts().prefetch.requested, 0u);
}

INSTANTIATE_TEST_SUITE_P(Seeds, EngineProperties, testing::Range(1u, 1 + lode::test::kSeeds));

}  // namespace
}  // namespace lode::core
