#include "server/ingest/pipeline/build_estimate.h"

#include <algorithm>
#include <cmath>

namespace lode::ingest {
namespace {

enum class Items : uint8_t {
  kUncounted,
  kReported,   ///< `done` and `total` of the reports
  kTriangles,  ///< `done` and `total` of the reports; `total` is the number of the model's triangles
  kFraction    ///< the finished fraction of the model's triangles
};

struct StageTraits {
  std::string_view name, doing;
  /// CPU seconds per million triangles (docs/benchmarks.md), and the share of these that is spent on one
  /// thread, as in the forecasts of `doctor`. The cost of images does not depend on triangles.
  double cpu_seconds, serial_share;
  Items items;
  std::string_view unit;
};

constexpr std::array<StageTraits, BuildEstimate::kStages> kTraits{{
    {"scan", "reading the file", 0.053, 1, Items::kReported, "B"},
    {"textures", "preparing images", 0, 0, Items::kReported, "tiles"},
    {"dereference", "making triangles", 0.06, 0.3, Items::kReported, "faces"},
    {"sort", "sorting triangles", 0.055, 0.3, Items::kUncounted, ""},
    {"partition", "dividing the model", 0.08, 0.3, Items::kTriangles, "triangles"},
    {"border", "matching borders", 0.02, 0.3, Items::kUncounted, ""},
    {"simplify", "simplifying", 2.7, 0, Items::kFraction, "triangles"},
    {"pack", "writing the store", 0.004, 1, Items::kUncounted, ""},
}};
constexpr size_t kScan = 0;
constexpr double kShortestRateS = 0.1;  ///< rates measured over a shorter time are unreliable

double unitOrZero(double fraction) { return std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0; }

}  // namespace

BuildEstimate::BuildEstimate(unsigned threads) {
  for (size_t i = 0; i < kStages; ++i) {
    const StageTraits& traits = kTraits[i];
    const double parallel = (1 - traits.serial_share) / std::max(1u, threads);
    states_[i].cost = traits.cpu_seconds * (traits.serial_share + parallel);
  }
}

void BuildEstimate::begin(size_t stage, double fraction) {
  begin_fraction_ = 0;
  if (current_ < kStages) {
    states_[current_].is_finished = true;
  } else if (stage != kScan) {
    begin_fraction_ = fraction;
    for (size_t i = 0; i < stage; ++i) loaded_cost_ += states_[i].cost;
    loaded_cost_ += fraction * states_[stage].cost;
  }
  current_ = stage;
  fraction_ = begin_fraction_;
}

void BuildEstimate::countItems(uint64_t done, uint64_t total) {
  const Items items = kTraits[current_].items;
  if (items == Items::kTriangles) triangles_ = static_cast<double>(total);
  done_ = total_ = 0;
  if (items == Items::kFraction) {
    total_ = triangles_;
    done_ = fraction_ * total_;
  } else if (items != Items::kUncounted) {
    total_ = static_cast<double>(total);
    done_ = static_cast<double>(done);
  }
}

void BuildEstimate::update(std::string_view stage, double fraction, uint64_t done, uint64_t total,
                           double seconds) {
  const auto* const found = std::ranges::find(kTraits, stage, &StageTraits::name);
  if (found == kTraits.end()) return;
  const auto index = static_cast<size_t>(found - kTraits.begin());
  if (index != current_) begin(index, unitOrZero(fraction));
  fraction_ = std::max(fraction_, unitOrZero(fraction));
  states_[current_].spent_s += std::max(0.0, seconds - seconds_);
  seconds_ = std::max(seconds_, seconds);
  countItems(done, total);
  const std::optional<double> left_s = secondsLeft();
  if (!left_s) return;
  const double finished_s = seconds_ + loaded_cost_ * secondsPerCost().value_or(0);
  if (finished_s + *left_s > 0) reached_ = std::max(reached_, finished_s / (finished_s + *left_s));
}

/// Returns the time per unit of cost, from the finished stages if possible. Uses the scan only if no other
/// stage has run, because its time depends on the file's encoding and on the disk.
std::optional<double> BuildEstimate::secondsPerCost() const {
  double cost = 0, spent_s = 0;
  for (size_t i = 0; i < kStages; ++i) {
    if (!states_[i].is_finished || i == kScan || states_[i].cost == 0) continue;
    cost += states_[i].cost;
    spent_s += states_[i].spent_s;
  }
  if (cost > 0) return spent_s / cost;
  if (states_[kScan].is_finished) return states_[kScan].spent_s / states_[kScan].cost;
  const double done = states_[current_].cost * (fraction_ - begin_fraction_);
  return done > 0 ? std::optional(states_[current_].spent_s / done) : std::nullopt;
}

std::optional<double> BuildEstimate::secondsLeft() const {
  const std::optional<double> per_cost = secondsPerCost();
  if (!per_cost) return std::nullopt;
  const State& current = states_[current_];
  const double run = fraction_ - begin_fraction_, to_run = 1 - begin_fraction_;
  // Part of the work of this stage that is finished, without the part that a resumed build has loaded.
  const double part = to_run > 0 ? run / to_run : 1;
  const double forecast_s = current.cost * to_run * *per_cost;
  // Time of the whole stage: mean of the forecast, with weight (1 - part)^2, and of spent_s / part.
  const double stage_s = (1 - part) * (1 - part) * forecast_s + (2 - part) * current.spent_s;
  double left_s = (1 - part) * stage_s;
  for (size_t i = current_ + 1; i < kStages; ++i) left_s += states_[i].cost * *per_cost;
  return left_s;
}

BuildStatus BuildEstimate::status() const {
  if (current_ == kStages) return {};
  BuildStatus status{.doing = kTraits[current_].doing,
                     .fraction = reached_,
                     .seconds_left = secondsLeft(),
                     .done = done_,
                     .total = total_,
                     .unit = kTraits[current_].unit};
  const double spent_s = states_[current_].spent_s;
  if (begin_fraction_ == 0 && spent_s > kShortestRateS) status.items_per_s = done_ / spent_s;
  return status;
}

}  // namespace lode::ingest
