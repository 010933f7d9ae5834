#include "client/render/cut_exchange.h"

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "client/core/shown_parts.h"

namespace lode::test {
namespace {

using core::Cut;
using core::CutPart;
using core::Fallback;
using render::CutExchange;
using render::ExchangeStep;

std::shared_ptr<const Mesh> aMesh() { return std::make_shared<const Mesh>(); }

/// Meshes of a model, each node's rungs made once.
class Meshes {
 public:
  std::shared_ptr<const Mesh> of(NodeKey node, uint32_t rung) {
    std::shared_ptr<const Mesh>& mesh = known_[{node, rung}];
    if (!mesh) mesh = aMesh();
    return mesh;
  }

 private:
  std::map<std::pair<NodeKey, uint32_t>, std::shared_ptr<const Mesh>> known_;
};

/// Cuts as a refiner makes them, of nodes that split, are left out or have fallbacks by chance.
class RandomCuts {
 public:
  RandomCuts(uint32_t seed, Meshes& meshes) : random_(seed), meshes_(meshes) {}

  std::shared_ptr<const Cut> make() {
    cut_ = std::make_shared<Cut>();
    lacking_.clear();
    descend(kRootKey);
    return std::exchange(cut_, nullptr);
  }

 private:
  void descend(NodeKey node) {
    const bool is_root = node == kRootKey;
    if (!is_root && random_() % 5 == 0) {
      lacking_.push_back({node, {}});
      return;
    }
    if (!is_root && (node.depth() == 4 || random_() % 3 == 0)) {
      cut_->parts.push_back(part(node));
      return;
    }
    const size_t parts = cut_->parts.size(), lacking = lacking_.size(), fallbacks = cut_->fallbacks.size();
    for (unsigned octant = 0; octant < 8; ++octant) descend(node.child(octant));
    if (lacking_.size() == lacking || (!is_root && random_() % 2 == 0)) return;
    Fallback fallback{part(node),
                      static_cast<uint32_t>(parts),
                      static_cast<uint32_t>(cut_->parts.size()),
                      static_cast<uint32_t>(cut_->left_out.size()),
                      0,
                      static_cast<uint32_t>(fallbacks)};
    cut_->left_out.insert(cut_->left_out.end(), lacking_.begin() + static_cast<std::ptrdiff_t>(lacking),
                          lacking_.end());
    lacking_.resize(lacking);
    fallback.end_left_out = static_cast<uint32_t>(cut_->left_out.size());
    cut_->fallbacks.push_back(fallback);
  }

  CutPart part(NodeKey node) {
    const auto rung = static_cast<uint32_t>(random_() % 2);
    return {node, rung, random_() % 2 == 0, static_cast<float>(random_() % 100), meshes_.of(node, rung)};
  }

  std::mt19937 random_;
  Meshes& meshes_;
  std::shared_ptr<Cut> cut_;
  std::vector<core::LeftOut> lacking_;
};

constexpr uint32_t kSeeds = 30;

/// Calls check(from, to, exchange) for many.
template <typename Check>
void forRandomExchanges(Check check) {
  for (uint32_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    Meshes meshes;
    RandomCuts cuts(seed, meshes);
    const auto from = cuts.make(), to = cuts.make();
    check(*from, *to, CutExchange(from, to));
  }
}

std::set<const Mesh*> meshesOf(const Cut& cut) {
  std::set<const Mesh*> meshes;
  for (size_t number = 0; number < partCount(cut); ++number) meshes.insert(partOf(cut, number).mesh.get());
  return meshes;
}

/// How much of the model is covered, in cells of depth 4, each of which must be covered once.
void expectCoveredOnce(const Cut& cut, std::span<const CutPart> parts,
                       std::span<const core::LeftOut> left_out) {
  std::vector<NodeKey> nodes;
  for (const CutPart& part : parts) nodes.push_back(part.node);
  for (const core::LeftOut& place : left_out) nodes.push_back(place.node);
  uint64_t cells = 0;
  for (const NodeKey node : nodes) cells += uint64_t{1} << 3 * (4 - node.depth());
  ASSERT_EQ(cells, uint64_t{1} << 12) << cut.parts.size();
  std::ranges::sort(nodes);
  for (const NodeKey node : nodes)
    for (NodeKey above = node; above != kRootKey;) {
      above = above.parent();
      ASSERT_FALSE(std::ranges::binary_search(nodes, above));
    }
}

TEST(CutExchange, coversTheModelOnceAfterEachOfItsSteps) {
  forRandomExchanges([](const Cut&, const Cut&, const CutExchange& exchange) {
    for (size_t steps = 0; steps <= exchange.steps().size(); ++steps) {
      const auto cut = exchange.after(steps);
      expectCoveredOnce(*cut, cut->parts, cut->left_out);
    }
  });
}

TEST(CutExchange, needsOnlyMeshesOfTheOlderCutAndOfTheStepsThatAreDone) {
  forRandomExchanges([](const Cut& from, const Cut& to, const CutExchange& exchange) {
    std::set<const Mesh*> there = meshesOf(from);
    for (size_t steps = 1; steps < exchange.steps().size(); ++steps) {
      for (const uint32_t number : exchange.steps()[steps - 1].numbers)
        there.insert(partOf(to, number).mesh.get());
      EXPECT_TRUE(std::ranges::includes(there, meshesOf(*exchange.after(steps))));
    }
  });
}

TEST(CutExchange, drawsTheNewerCutWhereARegionHasChangedHandsAndTheOlderElsewhere) {
  forRandomExchanges([](const Cut& from, const Cut& to, const CutExchange& exchange) {
    const std::set<const Mesh*> of_from = meshesOf(from), of_to = meshesOf(to);
    const size_t steps = (exchange.steps().size() + 1) / 2;
    if (steps < 2) return;
    const auto mixture = exchange.after(steps);
    const auto isDone = [&](NodeKey node) {
      return std::ranges::any_of(exchange.steps().subspan(1, steps - 1),
                                 [&](const ExchangeStep& step) { return step.region->contains(node); });
    };
    for (const CutPart& part : mixture->parts)
      EXPECT_TRUE((isDone(part.node) ? of_to : of_from).contains(part.mesh.get()));
  });
}

/// What shownParts() relies on.
/// @param cuts  that fallbacks may come from.
void expectSoundFallbacks(const Cut& cut, std::initializer_list<const Cut*> cuts) {
  std::set<NodeKey> nodes;
  for (const Cut* const of : cuts)
    for (const Fallback& fallback : of->fallbacks) nodes.insert(fallback.part.node);
  uint32_t places = 0;
  for (size_t i = 0; i < cut.fallbacks.size(); ++i) {
    const Fallback& fallback = cut.fallbacks[i];
    const NodeKey node = fallback.part.node;
    for (uint32_t part = 0; part < cut.parts.size(); ++part)
      EXPECT_EQ(node.contains(cut.parts[part].node), part >= fallback.first_part && part < fallback.end_part);
    for (uint32_t other = 0; other < i; ++other)
      EXPECT_EQ(node.contains(cut.fallbacks[other].part.node), other >= fallback.first_nested);
    for (uint32_t place = fallback.first_left_out; place < fallback.end_left_out; ++place) {
      NodeKey nearest = cut.left_out[place].node;
      while (nearest != kRootKey && !nodes.contains(nearest)) nearest = nearest.parent();
      EXPECT_EQ(nearest, node);
    }
    EXPECT_LT(fallback.first_left_out, fallback.end_left_out) << "something needs it";
    places += fallback.end_left_out - fallback.first_left_out;
  }
  EXPECT_EQ(places, cut.left_out.size()) << "each has one fallback";
}

TEST(CutExchange, keepsForEachPlaceThatIsLeftOutTheNearestFallback) {
  forRandomExchanges([](const Cut& from, const Cut& to, const CutExchange& exchange) {
    expectSoundFallbacks(from, {&from});
    for (size_t steps = 0; steps <= exchange.steps().size(); ++steps) {
      const bool is_mixed = steps > 1 && steps < exchange.steps().size();
      const auto cut = exchange.after(steps);
      is_mixed ? expectSoundFallbacks(*cut, {&from, &to}) : expectSoundFallbacks(*cut, {cut.get()});
    }
  });
}

TEST(CutExchange, beginsWithTheOlderCutAndEndsWithTheNewerItself) {
  Meshes meshes;
  RandomCuts cuts(1, meshes);
  const auto from = cuts.make(), to = cuts.make();
  const CutExchange exchange(from, to);
  EXPECT_EQ(exchange.after(0), from);
  EXPECT_EQ(exchange.after(1), from) << "fallbacks alone change nothing";
  EXPECT_EQ(exchange.after(exchange.steps().size()), to);
}

std::shared_ptr<Cut> cutOfChildren(std::initializer_list<CutPart> parts) {
  auto cut = std::make_shared<Cut>();
  cut->parts = parts;
  return cut;
}

NodeKey child(unsigned octant) { return kRootKey.child(octant); }

TEST(CutExchange, takesFirstWhatIsInSightAndThereWhatWasLeftOutOrCoarsest) {
  const auto from = cutOfChildren(
      {{child(0), 1, true, 2, aMesh()}, {child(1), 1, true, 8, aMesh()}, {child(2), 1, true, 9, aMesh()}});
  from->left_out = {{child(3), {}}};
  const auto to = cutOfChildren({{child(0), 0, true, 1, aMesh()},
                                 {child(1), 0, true, 1, aMesh()},
                                 {child(2), 0, false, 1, aMesh()},
                                 {child(3), 0, true, 1, aMesh()}});
  const CutExchange exchange(from, to);
  std::vector<NodeKey> order;
  for (const ExchangeStep& step : exchange.steps().subspan(1)) order.push_back(*step.region);
  EXPECT_EQ(order, (std::vector{child(3), child(1), child(0), child(2)}));
}

TEST(CutExchange, tellsOfAPartThatBothHaveTheNewerCutsError) {
  const auto both = aMesh();
  const auto from = cutOfChildren(
      {{child(0), 0, true, 5, both}, {child(1), 1, true, 8, aMesh()}, {child(2), 1, true, 8, aMesh()}});
  const auto to = cutOfChildren(
      {{child(0), 0, true, 3, both}, {child(1), 0, true, 1, aMesh()}, {child(2), 0, true, 1, aMesh()}});
  from->threshold_px = 2;
  const auto mixture = CutExchange(from, to).after(2);
  EXPECT_EQ(mixture->parts[0].error_px, 3);
  EXPECT_EQ(mixture->threshold_px, 2) << "it is no finer than what there is of the older";
  EXPECT_EQ(mixture->max_error_px, 8);
}

TEST(CutExchange, keepsBothCutsAliveWithTheirMixture) {
  auto from = cutOfChildren({{child(0), 1, true, 8, aMesh()}, {child(1), 1, true, 8, aMesh()}});
  auto to = cutOfChildren({{child(0), 0, true, 1, aMesh()}, {child(1), 0, true, 1, aMesh()}});
  const std::weak_ptr<const Cut> older = from, newer = to;
  auto mixture = CutExchange(std::move(from), std::move(to)).after(2);
  EXPECT_FALSE(older.expired());
  EXPECT_FALSE(newer.expired());
  mixture.reset();
  EXPECT_TRUE(older.expired());
}

TEST(CutExchange, hasTheTilesOfBothEachOnce) {
  const auto tile = [](uint32_t level, uint32_t x) { return core::ResidentTile{{level, 0, 0, x}, nullptr}; };
  const auto from = cutOfChildren({{child(0), 1, true, 8, aMesh()}, {child(1), 1, true, 8, aMesh()}});
  from->tiles = {tile(1, 0), tile(0, 0)};
  const auto to = cutOfChildren({{child(0), 0, true, 1, aMesh()}, {child(1), 0, true, 1, aMesh()}});
  to->tiles = {tile(1, 0), tile(0, 1)};
  const auto mixture = CutExchange(from, to).after(2);
  std::vector<core::TileKey> keys;
  for (const core::ResidentTile& of : mixture->tiles) keys.push_back(of.key);
  EXPECT_EQ(keys, (std::vector<core::TileKey>{{1, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 1}}));
}

TEST(CutExchange, isOneStepWhereNothingWasDrawnBefore) {
  Meshes meshes;
  const auto to = RandomCuts(1, meshes).make();
  const CutExchange exchange(nullptr, to);
  ASSERT_EQ(exchange.steps().size(), 1u);
  EXPECT_EQ(exchange.steps()[0].numbers.size(), partCount(*to));
  EXPECT_EQ(exchange.after(1), to);
}

}  // namespace
}  // namespace lode::test
