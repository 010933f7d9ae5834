#include "client/render/cross_fade.h"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "client/core/shown_parts.h"
#include "client/core/sight.h"

namespace lode::render {
namespace {

/// Of a fade that began then, 0..1.
float progressOf(double start_s, double now_s) {
  return static_cast<float>(std::clamp((now_s - start_s) / kFadeS, 0.0, 1.0));
}

}  // namespace

void CrossFade::show(const ShownCover& cover, const core::View& view, double lattice_step,
                     const DrawTime& time) {
  const core::Sight sight(view, 1);
  if (!time.fades) forget();
  std::erase_if(leaving_, [&](const Part& part) { return progressOf(part.left_s, time.now_s) >= 1; });
  if (cover.cut != cut_ || !std::ranges::equal(cover.numbers, numbers_))
    change(cover, sight, lattice_step, time.now_s);
  lost_ = false;
  endFadesInSight(sight);
  list(time.now_s);
}

void CrossFade::forget() {
  leaving_.clear();
  gaps_.clear();
  for (Part& part : live_) part.arrived_s = kEver;
  lost_ = true;
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
        {cover.drawn[number], core::partOf(*cover.cut, number).mesh.get(), now_s, kEver, 0, cover.serial});
  }
  return parts;
}

/// Lets live_ be the new cover; what stays keeps its clock.
CrossFade::Change CrossFade::take(const ShownCover& cover, double now_s) {
  Change change;
  change.before = std::exchange(live_, partsOf(cover, now_s));
  std::unordered_map<uint64_t, uint32_t> gone;  // by node
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

/// First what cannot fade, since it ends fades around it.
void CrossFade::change(const ShownCover& cover, const core::Sight& sight, double lattice_step, double now_s) {
  const Change change = take(cover, now_s);
  std::vector<const ChangedRegion*> fading;
  std::vector<NodeKey> ended;
  for (const ChangedRegion& region : change.regions) {
    if (mayFade(change, region, sight, lattice_step))
      fading.push_back(&region);
    else if (const auto node = endFadesAt(region.node))
      ended.push_back(*node);
  }
  for (const ChangedRegion* const region : fading) {
    if (std::ranges::any_of(ended, [&](NodeKey node) { return node.contains(region->node); })) continue;
    for (const uint32_t index : region->arriving) live_[index].arrived_s = now_s;
    for (const uint32_t index : region->leaving) {
      leaving_.push_back(change.before[index]);
      leaving_.back().left_s = now_s;
    }
    std::ranges::move(gapsOf(change, *region), std::back_inserter(gaps_));
  }
}

bool CrossFade::mayFade(const Change& change, const ChangedRegion& region, const core::Sight& sight,
                        double lattice_step) const {
  if (lost_ || region.leaving.empty() || region.arriving.empty()) return false;
  if (change.cut_before->build != cut_->build) return false;  // no error tells how far they are apart
  const auto fits = [&](const DrawItem& item) {
    const double distance_model = sight.distanceTo(core::toModelBox(item.box, lattice_step));
    return sight.errorPx(item.error_model, distance_model) <= kLargestFadedStepPx;
  };
  return std::ranges::all_of(region.leaving, [&](uint32_t i) { return fits(change.before[i].item); }) &&
         std::ranges::all_of(region.arriving, [&](uint32_t i) { return fits(live_[i].item); });
}

std::vector<CrossFade::Gap> CrossFade::gapsOf(const Change& change, const ChangedRegion& region) const {
  std::vector<Gap> gaps;
  const auto add = [&](const core::Cut* cut, std::span<const uint32_t> indices, std::span<const Part> parts) {
    if (cut == nullptr || cut->left_out.empty()) return;
    std::unordered_set<uint64_t> covered;
    for (const uint32_t index : indices) covered.insert(parts[index].item.node.value);
    for (const core::LeftOut& place : cut->left_out) {
      if (!region.node.contains(place.node)) continue;
      NodeKey above = place.node;
      while (above != region.node && !covered.contains(above.value)) above = above.parent();
      if (!covered.contains(above.value)) gaps.push_back({region.node, place.box});
    }
  };
  add(change.cut_before.get(), region.leaving, change.before);
  add(cut_.get(), region.arriving, live_);
  return gaps;
}

/// Shows the newest cover alone there, and wherever a part that leaves reaches from there.
/// @return where; nothing if none was under way.
std::optional<NodeKey> CrossFade::endFadesAt(NodeKey node) {
  const auto meets = [&](const Part& part) {
    return node.contains(part.item.node) || part.item.node.contains(node);
  };
  if (std::ranges::none_of(leaving_, meets)) return std::nullopt;
  const auto widen = [&](const std::vector<Part>& parts) {
    for (const Part& part : parts) {
      if (part.item.node.contains(node)) node = part.item.node;
    }
  };
  widen(leaving_);
  widen(live_);
  std::erase_if(leaving_, [&](const Part& part) { return node.contains(part.item.node); });
  for (Part& part : live_) {
    if (node.contains(part.item.node)) part.arrived_s = kEver;
  }
  return node;
}

/// Where the camera sees a place that one side does not cover, or has turned to one.
void CrossFade::endFadesInSight(const core::Sight& sight) {
  if (leaving_.empty()) gaps_.clear();
  for (const Gap& gap : std::vector(gaps_)) {
    if (sight.see(gap.box) != core::Seen::kNot) endFadesAt(gap.node);
  }
}

/// A part has the pixels that it has come to, less those that what follows it has taken.
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
