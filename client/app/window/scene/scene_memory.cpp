#include "client/app/window/scene/scene_memory.h"

#include <algorithm>

namespace lode::app {
namespace {

constexpr uint64_t kEqualShare = 8;   // 1/8 of the budget is divided equally
constexpr uint64_t kChangeShare = 8;  // parts change only if at least one part would change by more than 1/8
constexpr int kMostChanges = 4;       // largest number of changes while the view stays the same

}  // namespace

SceneMemory::SceneMemory(uint64_t budget_bytes, size_t models)
    : budget_bytes_(budget_bytes), parts_(models, budget_bytes / std::max<size_t>(1, models)) {}

void SceneMemory::setView(const core::View& view, float threshold_px) {
  if (view == view_ && threshold_px == threshold_px_) return;
  view_ = view;
  threshold_px_ = threshold_px;
  changes_ = 0;
}

bool SceneMemory::share(std::span<const Need> needs) {
  if (changes_ >= kMostChanges || std::ranges::none_of(needs, &Need::is_short)) return false;
  double all_needs = 0;
  for (const Need& need : needs) all_needs += static_cast<double>(need.bytes);
  if (all_needs == 0) return false;
  const uint64_t equal_bytes = budget_bytes_ / kEqualShare / needs.size();
  const auto rest_bytes = static_cast<double>(budget_bytes_ - equal_bytes * needs.size());
  std::vector<uint64_t> parts;
  bool has_changed = false;
  for (size_t model = 0; model < needs.size(); ++model) {
    const double share = static_cast<double>(needs[model].bytes) / all_needs;
    const uint64_t part = equal_bytes + static_cast<uint64_t>(rest_bytes * share * (1 - 1e-9));
    const uint64_t change = std::max(part, parts_[model]) - std::min(part, parts_[model]);
    has_changed = has_changed || change > parts_[model] / kChangeShare;
    parts.push_back(part);
  }
  if (!has_changed) return false;
  parts_ = std::move(parts);
  ++changes_;
  return true;
}

std::vector<uint64_t> gpuBudgets(uint64_t budget_bytes, std::span<const GpuShare> models) {
  uint64_t held_bytes = 0;
  for (const GpuShare& model : models) held_bytes += model.held_bytes;
  std::vector<uint64_t> budgets;
  for (const GpuShare& model : models) {
    const uint64_t others_bytes = held_bytes - model.held_bytes;
    budgets.push_back(std::max(model.part_bytes, budget_bytes - std::min(budget_bytes, others_bytes)));
  }
  return budgets;
}

}  // namespace lode::app
