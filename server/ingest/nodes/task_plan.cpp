#include "server/ingest/nodes/task_plan.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace lode::ingest {
namespace {

/// Largest number of subtrees for each task. More subtrees make tasks more equal, but leave more nodes above
/// them, which no task builds.
constexpr size_t kMostSubtreesOfTask = 16;
/// The node at the root of a subtree takes about this part of the subtree's work. Measured on 10 million
/// triangles: 1/20 for the root of the tree, 1/15 one level below, 1/4 two levels below.
constexpr uint64_t kPartOfRoot = 16;

/// Subtrees of an octree that tasks build, and the work above them.
class Division {
 public:
  explicit Division(const TreeletPlan& treelets) : treelets_(treelets) { add(treelets.size() - 1); }

  size_t size() const noexcept { return dividable_.size() + whole_.size(); }
  /// Replaces the largest subtree that can be divided by the subtrees directly below its topmost treelet.
  /// @return false if no subtree can be divided.
  bool divideLargest() {
    if (dividable_.empty()) return false;
    const uint32_t top = dividable_.top().second;
    dividable_.pop();
    work_above_ += treelets_[top].leaf_bytes / kPartOfRoot + ownBytes(top);
    for (const uint32_t below : treelets_.below(top)) add(below);
    return true;
  }

  /// Assigns each subtree to the task with the least work so far, large subtrees first.
  /// @param tasks  the task of each topmost treelet, by treelet. @return the work of the largest task and of
  /// the nodes above all subtrees: a measure of the time until the tree is built.
  uint64_t assign(uint32_t tasks, std::vector<uint32_t>& task_of) const {
    std::vector<uint32_t> subtrees = whole_;
    for (auto left = dividable_; !left.empty(); left.pop()) subtrees.push_back(left.top().second);
    std::sort(subtrees.begin(), subtrees.end(), [&](uint32_t a, uint32_t b) {
      return std::pair(treelets_[b].leaf_bytes, a) < std::pair(treelets_[a].leaf_bytes, b);
    });
    using Load = std::pair<uint64_t, uint32_t>;  // bytes, task
    std::priority_queue<Load, std::vector<Load>, std::greater<>> loads;
    for (uint32_t task = 0; task < tasks; ++task) loads.push({0, task});
    uint64_t largest = 0;
    task_of.assign(treelets_.size(), tasks);
    for (const uint32_t subtree : subtrees) {
      auto [bytes, task] = loads.top();
      loads.pop();
      bytes += treelets_[subtree].leaf_bytes;
      largest = std::max(largest, bytes);
      loads.push({bytes, task});
      task_of[subtree] = task;
    }
    return largest + work_above_;
  }

 private:
  void add(size_t treelet) {
    const auto number = static_cast<uint32_t>(treelet);
    if (treelets_.below(number).empty()) {
      whole_.push_back(number);
    } else {
      dividable_.push({treelets_[number].leaf_bytes, number});
    }
  }

  /// Returns the size of the leaves in a treelet.
  uint64_t ownBytes(uint32_t treelet) const {
    uint64_t bytes = treelets_[treelet].leaf_bytes;
    for (const uint32_t below : treelets_.below(treelet)) bytes -= treelets_[below].leaf_bytes;
    return bytes;
  }

  const TreeletPlan& treelets_;
  std::priority_queue<std::pair<uint64_t, uint32_t>> dividable_;  ///< leaf bytes and topmost treelet
  std::vector<uint32_t> whole_;
  uint64_t work_above_ = 0;
};

}  // namespace

std::vector<uint32_t> planTasks(const TreeletPlan& treelets, uint32_t tasks) {
  Division division(treelets);
  std::vector<uint32_t> best, task_of;
  uint64_t least_work = std::numeric_limits<uint64_t>::max();
  for (size_t of_task = 0; of_task <= kMostSubtreesOfTask; ++of_task) {
    while (division.size() < of_task * tasks && division.divideLargest()) {
    }
    const uint64_t work = division.assign(tasks, task_of);
    if (work < least_work) best = task_of;
    least_work = std::min(least_work, work);
  }
  for (auto treelet = static_cast<uint32_t>(treelets.size() - 1); treelet-- > 0;) {  // from the root down
    const uint32_t above = best[treelets.above(treelet)];
    if (above != tasks) best[treelet] = above;
  }
  return best;
}

}  // namespace lode::ingest
