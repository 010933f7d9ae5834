#include "client/render/passes/cross_fade.h"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "client/core/lod/cut.h"
#include "client/core/view/view.h"

namespace lode::render {
namespace {

/// Returns the progress of a fade, 0..1.
float progressOf(double start_s, double now_s) {
  return static_cast<float>(std::clamp((now_s - start_s) / kFadeS, 0.0, 1.0));
}

auto placeOf(const ChangedRegion* region) { return depthFirst(region->node); }

/// Returns true if a node is in one of the regions. @param nodes  nodes of disjoint regions, depth first.
bool isWithin(NodeKey node, std::span<const NodeKey> nodes) {
  const auto after = std::ranges::upper_bound(nodes, depthFirst(node), {}, depthFirst);
  return after != nodes.begin() && (after - 1)->contains(node);
}

}  // namespace

void CrossFade::show(const ShownCover& cover, const core::View& view, double lattice_step,
                     const DrawTime& time) {
  const core::ViewFrustum frustum(view, 1);
  if (!time.fades) forget();
  std::erase_if(leaving_, [&](const Part& part) { return progressOf(part.left_s, time.now_s) >= 1; });
  if (cover.cut != cut_ || !std::ranges::equal(cover.numbers, numbers_))
    change(cover, frustum, lattice_step, time.now_s);
  is_forgotten_ = false;
  endFadesInSight(frustum, time.now_s);
  list(time.now_s);
}

void CrossFade::forget() {
  leaving_.clear();
  gaps_.clear();
  for (Part& part : live_) part.arrived_s = kLongAgo;
  is_forgotten_ = true;
}

uint64_t CrossFade::oldestSerial() const noexcept {
  uint64_t oldest = std::numeric_limits<uint64_t>::max();
  for (const Part& part : leaving_) oldest = std::min(oldest, part.serial);
  return oldest;
}

std::vector<CrossFade::Part> CrossFade::partsOf(const ShownCover& cover, double now_s) {
  std::vector<Part> parts;
  parts.reserve(cover.numbers.size());
  for (const uint32_t number : cover.numbers) {
    if (cover.drawn[number].index_count == 0) continue;
    parts.push_back(
        {cover.drawn[number], core::partOf(*cover.cut, number).mesh.get(), now_s, kLongAgo, 0, cover.serial});
  }
  return parts;
}

/// Sets live_ to the new cover. Parts that are in both covers keep their fade times.
CrossFade::Change CrossFade::take(const ShownCover& cover, double now_s) {
  Change change;
  change.before = std::exchange(live_, partsOf(cover, now_s));
  std::unordered_map<uint64_t, uint32_t> gone;  // maps a node to its index in change.before
  for (uint32_t i = 0; i < change.before.size(); ++i) gone.emplace(change.before[i].item.node.value, i);
  std::vector<uint32_t> leaving, arriving;
  for (uint32_t i = 0; i < live_.size(); ++i) {
    const auto it = gone.find(live_[i].item.node.value);
    if (it == gone.end() || change.before[it->second].mesh != live_[i].mesh) {
      arriving.push_back(i);
    } else {
      live_[i].arrived_s = change.before[it->second].arrived_s;
      live_[i].since_s = change.before[it->second].since_s;
      gone.erase(it);
    }
  }
  for (const auto& [node, i] : gone) leaving.push_back(i);
  std::vector<NodeKey> leaving_nodes, arriving_nodes;
  for (const uint32_t i : leaving) leaving_nodes.push_back(change.before[i].item.node);
  for (const uint32_t i : arriving) arriving_nodes.push_back(live_[i].item.node);
  change.regions = changedRegions(leaving_nodes, arriving_nodes);
  for (ChangedRegion& region : change.regions) {
    for (uint32_t& index : region.leaving) index = leaving[index];
    for (uint32_t& index : region.arriving) index = arriving[index];
  }
  change.cut_before = std::exchange(cut_, cover.cut);
  numbers_.assign(cover.numbers.begin(), cover.numbers.end());
  return change;
}

/// Starts the change of all regions. Begins with the regions that cannot fade, because they end running fades
/// that overlap them.
void CrossFade::change(const ShownCover& cover, const core::ViewFrustum& frustum, double lattice_step,
                       double now_s) {
  const Change change = take(cover, now_s);
  std::vector<const ChangedRegion*> fading;
  std::vector<NodeKey> at_once;
  for (const ChangedRegion& region : change.regions) {
    if (mayFade(change, region, frustum, lattice_step))
      fading.push_back(&region);
    else
      at_once.push_back(region.node);
  }
  const std::vector<NodeKey> ended = endFadesAt(at_once);
  std::erase_if(fading, [&](const ChangedRegion* region) { return isWithin(region->node, ended); });
  for (const ChangedRegion* const region : fading) {
    for (const uint32_t index : region->arriving) live_[index].arrived_s = now_s;
    for (const uint32_t index : region->leaving) {
      leaving_.push_back(change.before[index]);
      leaving_.back().left_s = now_s;
    }
  }
  noteGaps(change, fading, now_s + kFadeS);
}

bool CrossFade::mayFade(const Change& change, const ChangedRegion& region, const core::ViewFrustum& frustum,
                        double lattice_step) const {
  if (is_forgotten_ || region.leaving.empty() || region.arriving.empty()) return false;
  // Do not fade between two builds of the model, because their surfaces may be far apart.
  if (change.cut_before->build != cut_->build) return false;
  const auto fits = [&](const DrawItem& item) {
    const double distance_model = frustum.distanceTo(core::toModelBox(item.box, lattice_step));
    return frustum.errorPx(item.error_model, distance_model) <= kLargestFadedStepPx;
  };
  return std::ranges::all_of(region.leaving, [&](uint32_t i) { return fits(change.before[i].item); }) &&
         std::ranges::all_of(region.arriving, [&](uint32_t i) { return fits(live_[i].item); });
}

/// Adds the gaps of fading regions. A gap is the box of a node that a cut leaves out, if no shown part of the
/// cut covers the node.
void CrossFade::noteGaps(const Change& change, std::span<const ChangedRegion* const> regions,
                         double until_s) {
  const auto note = [&](const core::Cut* cut, bool is_before) {
    if (cut == nullptr || cut->left_out.empty() || regions.empty()) return;
    const std::vector<Part>& parts = is_before ? change.before : live_;
    std::unordered_set<uint64_t> covered;
    for (const Part& part : parts) covered.insert(part.item.node.value);
    for (const core::LeftOut& place : cut->left_out) {
      const auto after = std::ranges::upper_bound(regions, depthFirst(place.node), {}, placeOf);
      if (after == regions.begin() || !(*(after - 1))->node.contains(place.node)) continue;
      const NodeKey region = (*(after - 1))->node;
      NodeKey above = place.node;
      while (above != region && !covered.contains(above.value)) above = above.parent();
      if (!covered.contains(above.value)) gaps_.push_back({region, place.box, until_s});
    }
  };
  note(change.cut_before.get(), true);
  note(cut_.get(), false);
}

/// Ends all fades in regions that overlap these nodes.
/// @return the regions where fades ended, depth first.
std::vector<NodeKey> CrossFade::endFadesAt(std::span<const NodeKey> nodes) {
  std::vector<NodeKey> ended;
  if (leaving_.empty() || nodes.empty()) return ended;
  std::vector<NodeKey> shown;
  for (const Part& part : leaving_) shown.push_back(part.item.node);
  for (const Part& part : live_) shown.push_back(part.item.node);
  for (const ChangedRegion& region : changedRegions(nodes, shown)) {
    const bool fades = std::ranges::any_of(region.arriving, [&](uint32_t i) { return i < leaving_.size(); });
    if (fades && !region.leaving.empty()) ended.push_back(region.node);
  }
  std::erase_if(leaving_, [&](const Part& part) { return isWithin(part.item.node, ended); });
  for (Part& part : live_) {
    if (isWithin(part.item.node, ended)) part.arrived_s = kLongAgo;
  }
  return ended;
}

/// Ends fades in regions with a gap that the camera sees.
void CrossFade::endFadesInSight(const core::ViewFrustum& frustum, double now_s) {
  std::erase_if(gaps_, [&](const Gap& gap) { return gap.until_s <= now_s; });
  std::vector<NodeKey> seen;
  for (const Gap& gap : gaps_) {
    if (frustum.test(gap.box) != core::Visibility::kOutside) seen.push_back(gap.region);
  }
  endFadesAt(seen);
}

/// Fills items_. Each part is drawn for a range of dither values. The range ends at the fraction to which the
/// part has faded in. For a part that is being replaced, the range begins at the fraction to which its
/// replacements have faded in; for other parts, it begins at 0.
void CrossFade::list(double now_s) {
  items_.clear();
  items_.reserve(live_.size() + leaving_.size());
  const auto add = [&](const Part& part, float from) {
    FadedItem& faded = items_.emplace_back(FadedItem{part.item, from, progressOf(part.arrived_s, now_s)});
    faded.item.age_s = static_cast<float>(now_s - part.since_s);
  };
  for (const Part& part : live_) add(part, 0);
  for (const Part& part : leaving_) add(part, progressOf(part.left_s, now_s));
}

}  // namespace lode::render
