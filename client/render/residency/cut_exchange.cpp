#include "client/render/residency/cut_exchange.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/cut.h"
#include "client/render/residency/changed_regions.h"

namespace lode::render {
namespace {

using core::Cut;
using core::CutPart;
using core::Fallback;
using core::LeftOut;

/// Returns the sort key of post-order, in which a node follows its descendants.
constexpr std::pair<uint64_t, int> depthLast(NodeKey node) noexcept {
  return {((node.value + 1) << 3 * (kMaxDepth - node.depth())) - 1, -node.depth()};
}

NodeKey nodeOf(const CutPart& part) { return part.node; }
NodeKey nodeOf(const LeftOut& left_out) { return left_out.node; }

/// A node and the part that covers it. The mesh is null if the cut leaves the node out.
struct Covering {
  NodeKey node;
  const Mesh* mesh = nullptr;

  bool operator==(const Covering&) const = default;
  std::pair<uint64_t, int> order() const noexcept { return depthFirst(node); }
};

/// Returns the parts and left-out nodes of a cut, depth first.
std::vector<Covering> coverOf(const Cut& cut) {
  std::vector<Covering> cover;
  cover.reserve(cut.parts.size() + cut.left_out.size());
  for (const CutPart& part : cut.parts) cover.push_back({part.node, part.mesh.get()});
  for (const LeftOut& left_out : cut.left_out) cover.push_back({left_out.node, nullptr});
  const auto left_out = cover.begin() + static_cast<std::ptrdiff_t>(cut.parts.size());
  std::ranges::sort(left_out, cover.end(), {}, &Covering::order);
  std::ranges::inplace_merge(cover, left_out, {}, &Covering::order);
  return cover;
}

/// Returns the regions in which two covers differ, depth first. The node of a region is the shallowest node
/// that differs. No unchanged part lies below this node, so leaving and arriving parts cover the same region.
std::vector<NodeKey> regionsThatDiffer(const std::vector<Covering>& before,
                                       const std::vector<Covering>& now) {
  std::vector<NodeKey> regions;
  for (auto one = before.begin(), other = now.begin(); one != before.end() || other != now.end();) {
    if (one != before.end() && other != now.end() && *one == *other) {
      ++one;
      ++other;
      continue;
    }
    const bool leaves = other == now.end() || (one != before.end() && one->order() <= other->order());
    const NodeKey node = leaves ? (one++)->node : (other++)->node;
    if (regions.empty() || !regions.back().contains(node)) regions.push_back(node);
  }
  return regions;
}

/// Returns true if both cuts have the same cover. Most successive cuts of a scene differ only in the camera.
bool haveSameCover(const Cut& a, const Cut& b) {
  const auto isSamePart = [](const CutPart& one, const CutPart& other) {
    return one.node == other.node && one.mesh == other.mesh;
  };
  const auto isSamePlace = [](const LeftOut& one, const LeftOut& other) { return one.node == other.node; };
  return std::ranges::equal(a.parts, b.parts, isSamePart) &&
         std::ranges::equal(a.left_out, b.left_out, isSamePlace);
}

/// Returns the parts of a cut at and below a node.
std::span<const CutPart> partsIn(NodeKey node, const Cut& cut) {
  const auto first = std::ranges::lower_bound(cut.parts, depthFirst(node), {},
                                              [](const CutPart& part) { return depthFirst(part.node); });
  const auto isIn = [&](const CutPart& part) { return node.contains(part.node); };
  return {first, std::find_if_not(first, cut.parts.end(), isIn)};
}

/// Disjoint regions in depth-first order.
class Regions {
 public:
  explicit Regions(std::vector<NodeKey> nodes) : nodes_(std::move(nodes)) {
    std::ranges::sort(nodes_, {}, depthFirst);
  }
  std::span<const NodeKey> nodes() const noexcept { return nodes_; }
  /// Returns the index of the region that contains a node.
  std::optional<size_t> around(NodeKey node) const noexcept {
    const auto after = std::ranges::upper_bound(nodes_, depthFirst(node), {}, depthFirst);
    if (after == nodes_.begin() || !(after - 1)->contains(node)) return std::nullopt;
    return static_cast<size_t>(after - nodes_.begin()) - 1;
  }

 private:
  std::vector<NodeKey> nodes_;
};

/// A region to switch, with its priority.
struct PlannedRegion {
  ExchangeStep step;
  bool visible = false;
  float error_px = 0;  ///< largest error of the parts that are drawn now

  std::tuple<bool, float, uint32_t, std::pair<uint64_t, int>> order() const {
    return {!visible, -error_px, step.instance, depthFirst(*step.region)};
  }
};

/// Plans one region. The caller raises error_px if the older cut leaves out nodes of the region.
PlannedRegion planRegion(const Cut& from, const Cut& to, uint32_t instance, NodeKey region) {
  PlannedRegion planned;
  planned.step.instance = instance;
  planned.step.region = region;
  for (const CutPart& part : partsIn(region, to)) {
    planned.step.parts.push_back({instance, static_cast<uint32_t>(&part - to.parts.data())});
    planned.visible |= part.visible;
  }
  for (const CutPart& part : partsIn(region, from))
    planned.error_px = std::max(planned.error_px, part.error_px);
  return planned;
}

/// Plans the regions of one instance, depth first.
std::vector<PlannedRegion> regionsBetween(const Cut& from, const Cut& to, uint32_t instance) {
  if (haveSameCover(from, to)) return {};
  std::vector<PlannedRegion> planned;
  const Regions regions(regionsThatDiffer(coverOf(from), coverOf(to)));
  for (const NodeKey region : regions.nodes()) planned.push_back(planRegion(from, to, instance, region));
  for (const LeftOut& left_out : from.left_out)
    if (const auto region = regions.around(left_out.node))
      planned[*region].error_px = std::numeric_limits<float>::max();
  return planned;
}

/// Merges two lists. Takes the elements inside the kept regions from `from`, and the other elements from
/// `to`.
template <typename T>
std::vector<T> mixed(const std::vector<T>& from, const std::vector<T>& to, const Regions& kept) {
  std::vector<T> both;
  const auto isKept = [&](const T& one) { return kept.around(nodeOf(one)).has_value(); };
  std::ranges::copy_if(from, std::back_inserter(both), isKept);
  std::ranges::copy_if(to, std::back_inserter(both), [&](const T& one) { return !isKept(one); });
  std::ranges::sort(both, {}, [](const T& one) { return depthFirst(nodeOf(one)); });
  return both;
}

/// Returns the factor that converts pixels in the view of `from` to pixels in the view of `to`.
float pixelRatio(const Cut& from, const Cut& to) {
  return static_cast<float>(focalPx(to.view) / focalPx(from.view));
}

void measureIn(float pixel_ratio, CutPart& part) {
  part.error_px *= pixel_ratio;
  part.threshold_px *= pixel_ratio;
}

/// Returns the fallbacks of both cuts. If both cuts have a fallback for a node, returns the newer cut's.
std::vector<Fallback> fallbacksOf(const Cut& from, const Cut& to) {
  std::vector<Fallback> both = to.fallbacks;
  for (const Fallback& fallback : from.fallbacks)
    measureIn(pixelRatio(from, to), both.emplace_back(fallback).part);
  std::ranges::stable_sort(both, {}, [](const Fallback& one) { return depthLast(one.part.node); });
  const auto isSame = [](const Fallback& a, const Fallback& b) { return a.part.node == b.part.node; };
  both.erase(std::unique(both.begin(), both.end(), isSame), both.end());
  return both;
}

/// Gives a cut the fallbacks that its left-out nodes need. The cut's parts and left_out must be in
/// depth-first order.
void assign(std::vector<Fallback> fallbacks, Cut& cut) {
  std::unordered_map<uint64_t, std::vector<LeftOut>> left_out_below;  // maps the node of a fallback to the
                                                                      // left-out nodes below it
  for (const Fallback& fallback : fallbacks)
    left_out_below.emplace(fallback.part.node.value, std::vector<LeftOut>());
  for (const LeftOut& left_out : std::exchange(cut.left_out, {})) {
    NodeKey above = left_out.node;
    while (above != kRootKey && !left_out_below.contains(above.value)) above = above.parent();
    left_out_below[above.value].push_back(left_out);
  }
  for (Fallback& fallback : fallbacks) {
    const NodeKey node = fallback.part.node;
    const std::vector<LeftOut>& its_own = left_out_below[node.value];
    if (its_own.empty()) continue;
    const std::span<const CutPart> below = partsIn(node, cut);
    fallback.first_part = static_cast<uint32_t>(below.data() - cut.parts.data());
    fallback.end_part = fallback.first_part + static_cast<uint32_t>(below.size());
    fallback.first_left_out = static_cast<uint32_t>(cut.left_out.size());
    cut.left_out.insert(cut.left_out.end(), its_own.begin(), its_own.end());
    fallback.end_left_out = static_cast<uint32_t>(cut.left_out.size());
    auto nested = cut.fallbacks.size();
    while (nested > 0 && node.contains(cut.fallbacks[nested - 1].part.node)) --nested;
    fallback.first_nested = static_cast<uint32_t>(nested);
    cut.fallbacks.push_back(std::move(fallback));
  }
}

}  // namespace

CutExchange::CutExchange(Cuts from, Cuts to) : from_(std::move(from)), to_(std::move(to)) {
  ExchangeStep& first = steps_.emplace_back();
  for (uint32_t instance = 0; instance < to_.size(); ++instance) {
    const size_t parts = from_.empty() ? 0 : to_[instance]->parts.size();
    for (size_t number = parts; number < partCount(*to_[instance]); ++number)
      first.parts.push_back({instance, static_cast<uint32_t>(number)});
  }
  if (!from_.empty()) planRegions();
}

void CutExchange::planRegions() {
  std::vector<PlannedRegion> planned;
  for (uint32_t instance = 0; instance < to_.size(); ++instance)
    std::ranges::move(regionsBetween(*from_[instance], *to_[instance], instance),
                      std::back_inserter(planned));
  std::ranges::sort(planned, {}, &PlannedRegion::order);
  for (PlannedRegion& region : planned) steps_.push_back(std::move(region.step));
  mixtures_.resize(to_.size());
}

CutExchange::Cuts CutExchange::after(size_t steps) {
  if (steps == steps_.size()) return to_;
  if (steps == 0) return from_;
  std::vector<size_t> done(to_.size(), 0);
  for (const ExchangeStep& step : std::span(steps_).subspan(1, steps - 1)) ++done[step.instance];
  std::vector<std::vector<NodeKey>> left(to_.size());
  for (const ExchangeStep& step : std::span(steps_).subspan(steps))
    left[step.instance].push_back(*step.region);
  Cuts cuts = from_;
  for (uint32_t instance = 0; instance < to_.size(); ++instance) {
    if (left[instance].empty()) cuts[instance] = to_[instance];
    if (left[instance].empty() || done[instance] == 0) continue;
    Mixture& mixture = mixtures_[instance];
    if (mixture.steps != done[instance])
      mixture = {done[instance], mixtureAt(instance, std::move(left[instance]))};
    cuts[instance] = mixture.cut;
  }
  return cuts;
}

std::shared_ptr<const Cut> CutExchange::mixtureAt(uint32_t instance,
                                                  std::vector<NodeKey> regions_left) const {
  const Regions kept(std::move(regions_left));
  const Cut &from = *from_[instance], &to = *to_[instance];
  const auto cut = std::make_shared<Cut>();
  cut->view = to.view;
  const float pixel_ratio = pixelRatio(from, to);
  cut->threshold_px = std::max(pixel_ratio * from.threshold_px, to.threshold_px);
  cut->build = to.build;
  cut->parts = mixed(from.parts, to.parts, kept);
  for (CutPart& part : cut->parts)
    if (kept.around(part.node)) measureIn(pixel_ratio, part);
  cut->left_out = mixed(from.left_out, to.left_out, kept);
  assign(fallbacksOf(from, to), *cut);
  for (size_t number = 0; number < partCount(*cut); ++number) {
    const CutPart& part = partOf(*cut, number);
    if (part.mesh) cut->drawn_bytes += core::drawnBytes(*part.mesh);
    if (number >= cut->parts.size()) continue;
    if (part.mesh) cut->triangles += part.mesh->triangles.size();
    if (part.visible) cut->max_error_px = std::max(cut->max_error_px, part.error_px);
  }
  return cut;
}

}  // namespace lode::render
