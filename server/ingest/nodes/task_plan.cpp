#include "server/ingest/nodes/task_plan.h"

#include <algorithm>
#include <utility>

namespace lode::ingest {
namespace {

/// A subtree is divided if it has more than this part of a task's mean work.
constexpr uint64_t kMostOfTask = 8;
/// A subtree is not divided if more than this part of its work would be left over, because no task does it.
constexpr uint64_t kMostLeftOver = 10;
/// Largest depth of a subtree that is divided. The treelets above the divided subtrees are left over, too.
constexpr int kDeepestDivided = 3;

/// Returns the numbers of the topmost treelets of the subtrees that tasks build.
std::vector<uint32_t> divide(const TreeletPlan& treelets, uint32_t tasks) {
  const auto root = static_cast<uint32_t>(treelets.size() - 1);
  const uint64_t most_bytes = treelets[root].leaf_bytes / tasks / kMostOfTask;
  std::vector<uint32_t> left{root}, whole;
  while (!left.empty()) {
    const uint32_t top = left.back();
    left.pop_back();
    const std::vector<uint32_t> below = treelets.below(top);
    uint64_t own_bytes = treelets[top].leaf_bytes;
    for (const uint32_t subtree : below) own_bytes -= treelets[subtree].leaf_bytes;
    if (treelets[top].leaf_bytes > most_bytes && treelets.depth(top) <= kDeepestDivided &&
        own_bytes <= treelets[top].leaf_bytes / kMostLeftOver) {
      left.insert(left.end(), below.begin(), below.end());
    } else {
      whole.push_back(top);
    }
  }
  return whole;
}

}  // namespace

std::vector<uint32_t> planTasks(const TreeletPlan& treelets, uint32_t tasks) {
  const auto count = static_cast<uint32_t>(treelets.size());
  std::vector<uint32_t> task_of(count, tasks);
  std::vector<uint32_t> subtrees = divide(treelets, tasks);
  std::sort(subtrees.begin(), subtrees.end(), [&](uint32_t a, uint32_t b) {
    return std::pair(treelets[b].leaf_bytes, a) < std::pair(treelets[a].leaf_bytes, b);  // large ones first
  });
  std::vector<uint64_t> load(tasks);
  for (const uint32_t subtree : subtrees) {
    const auto least = std::min_element(load.begin(), load.end());
    *least += treelets[subtree].leaf_bytes;
    task_of[subtree] = static_cast<uint32_t>(least - load.begin());
  }
  for (uint32_t treelet = count - 1; treelet-- > 0;) {  // from the root down
    const uint32_t above = task_of[treelets.above(treelet)];
    if (above != tasks) task_of[treelet] = above;
  }
  return task_of;
}

}  // namespace lode::ingest
