#include "client/render/residency/cut_exchange.h"

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "client/core/lod/cut.h"

namespace lode::test {
namespace {

using core::Cut;
using core::CutPart;
using core::Fallback;
using render::CutExchange;
using render::ExchangeStep;

std::shared_ptr<const Mesh> aMesh() { return std::make_shared<const Mesh>(); }

/// Meshes of a model; creates each node's LODs once.
class Meshes {
 public:
  std::shared_ptr<const Mesh> of(NodeKey node, uint32_t lod) {
    std::shared_ptr<const Mesh>& mesh = known_[{node, lod}];
    if (!mesh) mesh = aMesh();
    return mesh;
  }

 private:
  std::map<std::pair<NodeKey, uint32_t>, std::shared_ptr<const Mesh>> known_;
};

/// Random cuts as a refiner makes them: nodes split, are left out or have fallbacks by chance.
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
    const auto lod = static_cast<uint32_t>(random_() % 2);
    return {node, lod, random_() % 2 == 0, static_cast<float>(random_() % 100), meshes_.of(node, lod)};
  }

  std::mt19937 random_;
  Meshes& meshes_;
  std::shared_ptr<Cut> cut_;
  std::vector<core::LeftOut> lacking_;
};

/// Exchange of a model with one instance.
class OneExchange {
 public:
  OneExchange(std::shared_ptr<const Cut> from, std::shared_ptr<const Cut> to)
      : exchange_({std::move(from)}, {std::move(to)}) {}
  std::span<const ExchangeStep> steps() const { return exchange_.steps(); }
  std::shared_ptr<const Cut> after(size_t steps) { return exchange_.after(steps).front(); }

 private:
  CutExchange exchange_;
};

constexpr uint32_t kSeeds = 30;

/// Calls check(from, to, exchange) for many random cuts.
template <typename Check>
void forRandomExchanges(Check check) {
  for (uint32_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    Meshes meshes;
    RandomCuts cuts(seed, meshes);
    const auto from = cuts.make(), to = cuts.make();
    OneExchange exchange(from, to);
    check(*from, *to, exchange);
  }
}

std::set<const Mesh*> meshesOf(const Cut& cut) {
  std::set<const Mesh*> meshes;
  for (size_t number = 0; number < partCount(cut); ++number) meshes.insert(partOf(cut, number).mesh.get());
  return meshes;
}

/// Counts the covered cells of depth 4 and checks that each is covered at most once.
void expectCoveredOnce(const Cut& cut, std::span<const CutPart> parts,
                       std::span<const core::LeftOut> left_out) {
  std::vector<NodeKey> nodes;
  for (const CutPart& part : parts) nodes.push_back(part.node);
  for (const core::LeftOut& instance : left_out) nodes.push_back(instance.node);
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
  forRandomExchanges([](const Cut&, const Cut&, OneExchange& exchange) {
    for (size_t steps = 0; steps <= exchange.steps().size(); ++steps) {
      const auto cut = exchange.after(steps);
      expectCoveredOnce(*cut, cut->parts, cut->left_out);
    }
  });
}

TEST(CutExchange, needsOnlyMeshesOfTheOlderCutAndOfTheStepsThatAreDone) {
  forRandomExchanges([](const Cut& from, const Cut& to, OneExchange& exchange) {
    std::set<const Mesh*> there = meshesOf(from);
    for (size_t steps = 1; steps < exchange.steps().size(); ++steps) {
      for (const render::InstancePart& part : exchange.steps()[steps - 1].parts)
        there.insert(partOf(to, part.number).mesh.get());
      EXPECT_TRUE(std::ranges::includes(there, meshesOf(*exchange.after(steps))));
    }
  });
}

TEST(CutExchange, drawsTheNewerCutOnlyInExchangedRegions) {
  forRandomExchanges([](const Cut& from, const Cut& to, OneExchange& exchange) {
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

/// Checks what shownParts() relies on. @param cuts  cuts that fallbacks may come from.
void expectSoundFallbacks(const Cut& cut, std::initializer_list<const Cut*> cuts) {
  std::set<NodeKey> nodes;
  for (const Cut* const of : cuts)
    for (const Fallback& fallback : of->fallbacks) nodes.insert(fallback.part.node);
  uint32_t instances = 0;
  for (size_t i = 0; i < cut.fallbacks.size(); ++i) {
    const Fallback& fallback = cut.fallbacks[i];
    const NodeKey node = fallback.part.node;
    for (uint32_t part = 0; part < cut.parts.size(); ++part)
      EXPECT_EQ(node.contains(cut.parts[part].node), part >= fallback.first_part && part < fallback.end_part);
    for (uint32_t other = 0; other < i; ++other)
      EXPECT_EQ(node.contains(cut.fallbacks[other].part.node), other >= fallback.first_nested);
    for (uint32_t instance = fallback.first_left_out; instance < fallback.end_left_out; ++instance) {
      NodeKey nearest = cut.left_out[instance].node;
      while (nearest != kRootKey && !nodes.contains(nearest)) nearest = nearest.parent();
      EXPECT_EQ(nearest, node);
    }
    EXPECT_LT(fallback.first_left_out, fallback.end_left_out) << "something needs it";
    instances += fallback.end_left_out - fallback.first_left_out;
  }
  EXPECT_EQ(instances, cut.left_out.size()) << "each has one fallback";
}

TEST(CutExchange, keepsTheNearestFallbackOfEachLeftOutNode) {
  forRandomExchanges([](const Cut& from, const Cut& to, OneExchange& exchange) {
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
  OneExchange exchange(from, to);
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

TEST(CutExchange, exchangesVisibleLeftOutOrCoarseRegionsFirst) {
  const auto from = cutOfChildren(
      {{child(0), 1, true, 2, aMesh()}, {child(1), 1, true, 8, aMesh()}, {child(2), 1, true, 9, aMesh()}});
  from->left_out = {{child(3), {}}};
  const auto to = cutOfChildren({{child(0), 0, true, 1, aMesh()},
                                 {child(1), 0, true, 1, aMesh()},
                                 {child(2), 0, false, 1, aMesh()},
                                 {child(3), 0, true, 1, aMesh()}});
  OneExchange exchange(from, to);
  std::vector<NodeKey> order;
  for (const ExchangeStep& step : exchange.steps().subspan(1)) order.push_back(*step.region);
  EXPECT_EQ(order, (std::vector{child(3), child(1), child(0), child(2)}));
}

TEST(CutExchange, givesSharedPartsTheNewerCutsError) {
  const auto both = aMesh();
  const auto from = cutOfChildren(
      {{child(0), 0, true, 5, both}, {child(1), 1, true, 8, aMesh()}, {child(2), 1, true, 8, aMesh()}});
  const auto to = cutOfChildren(
      {{child(0), 0, true, 3, both}, {child(1), 0, true, 1, aMesh()}, {child(2), 0, true, 1, aMesh()}});
  from->threshold_px = 2;
  const auto mixture = OneExchange(from, to).after(2);
  EXPECT_EQ(mixture->parts[0].error_px, 3);
  EXPECT_EQ(mixture->threshold_px, 2) << "it is no finer than what there is of the older";
  EXPECT_EQ(mixture->max_error_px, 8);
}

TEST(CutExchange, measuresPartsOfTheOlderCutInTheNewerCutsPixels) {
  const auto from = cutOfChildren(
      {{child(0), 1, true, 5, aMesh()}, {child(1), 1, true, 8, aMesh()}, {child(2), 1, true, 8, aMesh()}});
  const auto to = cutOfChildren(
      {{child(0), 0, true, 1, aMesh()}, {child(1), 0, true, 1, aMesh()}, {child(2), 0, true, 1, aMesh()}});
  from->view.height_px = 2 * to->view.height_px;
  from->threshold_px = 6;
  from->parts[0].threshold_px = 7;
  from->fallbacks = {{.part = {kRootKey, 1, false, 20, aMesh()}}};
  from->left_out = {{child(3), {}}};
  to->left_out = {{child(3), {}}};
  const auto mixture = OneExchange(from, to).after(3);
  EXPECT_EQ(mixture->parts[0].error_px, 2.5f);
  EXPECT_EQ(mixture->parts[0].threshold_px, 3.5f);
  EXPECT_EQ(mixture->parts[1].error_px, 1);
  EXPECT_EQ(mixture->threshold_px, 3);
  EXPECT_EQ(mixture->max_error_px, 2.5f);
  ASSERT_EQ(mixture->fallbacks.size(), 1u);
  EXPECT_EQ(mixture->fallbacks[0].part.error_px, 10);
}

/// Shows newer cuts before those in progress are complete.
TEST(CutExchange, coversTheModelOnceIfTheDrawnCutIsAMixture) {
  for (uint32_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    Meshes meshes;
    RandomCuts cuts(seed, meshes);
    std::shared_ptr<const Cut> drawn = cuts.make();
    std::vector<std::shared_ptr<const Cut>> shown{drawn};
    for (int turns = 0; turns < 5; ++turns) {
      shown.push_back(cuts.make());
      OneExchange exchange(drawn, shown.back());
      drawn = exchange.after(std::min<size_t>(2, exchange.steps().size()));
      expectCoveredOnce(*drawn, drawn->parts, drawn->left_out);
    }
    for (const Fallback& fallback : drawn->fallbacks)
      EXPECT_LT(fallback.first_left_out, fallback.end_left_out) << "something needs it";
  }
}

/// The first instance has a larger visible error than the second, which has one visible region and one not.
class TwoInstances {
 public:
  const CutExchange::Cuts from{
      cutOfChildren({{child(0), 1, true, 8, aMesh()}}),
      cutOfChildren({{child(0), 1, true, 4, aMesh()}, {child(1), 1, true, 9, aMesh()}})};
  const CutExchange::Cuts to{
      cutOfChildren({{child(0), 0, true, 1, aMesh()}}),
      cutOfChildren({{child(0), 0, true, 1, aMesh()}, {child(1), 0, false, 1, aMesh()}})};
  CutExchange exchange{from, to};
};

TEST(CutExchange, ordersTheRegionsOfAllInstancesByVisibilityAndError) {
  std::vector<std::pair<uint32_t, NodeKey>> order;
  const TwoInstances instances;
  for (const ExchangeStep& step : instances.exchange.steps().subspan(1)) {
    order.push_back({step.instance, *step.region});
    for (const render::InstancePart& part : step.parts) EXPECT_EQ(part.instance, step.instance);
  }
  EXPECT_EQ(order, (std::vector<std::pair<uint32_t, NodeKey>>{{0, child(0)}, {1, child(0)}, {1, child(1)}}));
}

TEST(CutExchange, exchangesTheRegionsOfEachInstanceSeparately) {
  TwoInstances instances;
  EXPECT_EQ(instances.exchange.after(2), (CutExchange::Cuts{instances.to[0], instances.from[1]}));
  const CutExchange::Cuts mixed = instances.exchange.after(3);
  EXPECT_EQ(mixed[0], instances.to[0]);
  EXPECT_EQ(mixed[1]->parts[0].mesh, instances.to[1]->parts[0].mesh);
  EXPECT_EQ(mixed[1]->parts[1].mesh, instances.from[1]->parts[1].mesh);
  EXPECT_EQ(instances.exchange.after(4), instances.to);
}

TEST(CutExchange, rebuildsOnlyTheMixturesOfChangedInstances) {
  const auto before = cutOfChildren({{child(0), 1, true, 9, aMesh()}, {child(1), 1, true, 2, aMesh()}});
  const auto next = cutOfChildren({{child(0), 0, true, 1, aMesh()}, {child(1), 0, true, 1, aMesh()}});
  const auto other_before = cutOfChildren({{child(0), 1, true, 8, aMesh()}, {child(1), 1, true, 1, aMesh()}});
  const auto other_next = cutOfChildren({{child(0), 0, true, 1, aMesh()}, {child(1), 0, true, 1, aMesh()}});
  CutExchange exchange({before, other_before}, {next, other_next});
  const CutExchange::Cuts first = exchange.after(2), second = exchange.after(3);
  EXPECT_EQ(second[0], first[0]);
  EXPECT_NE(second[1], first[1]);
}

TEST(CutExchange, changesNoRegionWhereTheNewerCutIsOfTheSameMeshes) {
  Meshes meshes;
  const auto from = RandomCuts(1, meshes).make();
  const auto to = std::make_shared<Cut>(*from);
  for (CutPart& part : to->parts) part.error_px += 1;
  EXPECT_EQ(CutExchange({from}, {to}).steps().size(), 1u);
}

TEST(CutExchange, changesOnlyTheRegionThatIsNoLongerLeftOut) {
  const auto mesh = aMesh();
  const auto from = cutOfChildren({{child(3), 0, true, 1, mesh}});
  from->left_out = {{child(7), {}}, {child(0), {}}};
  const auto to = cutOfChildren({{child(3), 0, true, 1, mesh}, {child(7), 0, true, 1, aMesh()}});
  to->left_out = {{child(0), {}}};
  std::vector<std::optional<NodeKey>> regions;
  const CutExchange exchange({from}, {to});
  for (const ExchangeStep& step : exchange.steps().subspan(1)) regions.push_back(step.region);
  EXPECT_EQ(regions, (std::vector<std::optional<NodeKey>>{child(7)}));
}

TEST(CutExchange, isOneStepWhereNothingWasDrawnBefore) {
  Meshes meshes;
  RandomCuts cuts(1, meshes);
  const CutExchange::Cuts to{cuts.make(), cuts.make()};
  CutExchange exchange({}, to);
  ASSERT_EQ(exchange.steps().size(), 1u);
  EXPECT_EQ(exchange.steps()[0].parts.size(), partCount(*to[0]) + partCount(*to[1]));
  EXPECT_EQ(exchange.after(1), to);
}

}  // namespace
}  // namespace lode::test
