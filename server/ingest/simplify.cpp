#include "server/ingest/simplify.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <queue>
#include <thread>

namespace lode::ingest {
namespace {

constexpr auto kProgressInterval = std::chrono::milliseconds(200);

/// Nodes of the tree in post-order: a child's number is below its parent's, and a node's children are the
/// roots of the subtrees that end before it.
struct Plan {
  struct Entry {
    NodeKey key;
    uint32_t parent = 0;
    uint32_t leaf = 0;  ///< number of the leaf, where children is empty
    std::vector<uint32_t> children;
  };
  std::vector<Entry> entries;

  explicit Plan(const std::vector<NodeKey>& leaves) {
    size_t next = 0;
    plan(kRootKey, leaves, next);
  }

 private:
  uint32_t plan(NodeKey key, const std::vector<NodeKey>& leaves, size_t& next) {
    Entry entry{key, 0, static_cast<uint32_t>(next), {}};
    if (leaves[next] == key) {
      ++next;
    } else {
      for (unsigned octant = 0; octant < 8 && next < leaves.size(); ++octant) {
        const NodeKey child = key.child(octant);
        if (child.contains(leaves[next])) entry.children.push_back(plan(child, leaves, next));
      }
    }
    const auto number = static_cast<uint32_t>(entries.size());
    for (const uint32_t child : entry.children) entries[child].parent = number;
    entries.push_back(std::move(entry));
    return number;
  }
};

/// Shared state of the workers; everything in it is guarded by the mutex but `plan`, which does not change.
class Scheduler {
 public:
  explicit Scheduler(const Plan& plan)
      : plan_(plan), built_(plan.entries.size()), waiting_for_(plan.entries.size()) {
    for (size_t i = 0; i < plan.entries.size(); ++i) {
      waiting_for_[i] = plan.entries[i].children.size();
      if (plan.entries[i].children.empty()) leaf_entries_.push_back(static_cast<uint32_t>(i));
    }
    tree_.nodes.resize(plan.entries.size());
    tree_.payloads.resize(plan.entries.size());
  }

  template <typename MakeBuilder>
  void work(MakeBuilder&& make_builder) noexcept {
    try {
      NodeBuilder builder = make_builder();
      while (const auto number = take()) {
        const Plan::Entry& entry = plan_.entries[*number];
        if (entry.children.empty()) {
          give(*number, builder.buildLeaf(entry.leaf));
        } else {
          std::vector<BuiltNode> children = takeChildren(entry);
          give(*number, builder.buildInner(entry.key, children));
        }
      }
    } catch (...) {
      std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
      changed_.notify_all();
    }
  }

  /// Ends when all is built, or when a worker or `progress` has thrown.
  void waitUntilDone(const BuildProgress& progress) {
    std::unique_lock lock(mutex_);
    while (done_ < built_.size() && !failure_) {
      changed_.wait_for(lock, kProgressInterval);
      if (!progress) continue;
      const size_t done = done_;
      lock.unlock();
      std::exception_ptr failure;
      try {
        progress("simplify", static_cast<double>(done) / static_cast<double>(built_.size()), done,
                 built_.size());
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      if (failure && !failure_) failure_ = failure;
    }
    changed_.notify_all();
  }

  SimplifiedTree result() {
    if (failure_) std::rethrow_exception(failure_);
    std::vector<uint32_t> order(plan_.entries.size());
    for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return plan_.entries[a].key < plan_.entries[b].key; });
    SimplifiedTree sorted;
    for (const uint32_t number : order) {
      sorted.nodes.push_back(std::move(tree_.nodes[number]));
      sorted.payloads.push_back(std::move(tree_.payloads[number]));
    }
    return sorted;
  }

 private:
  /// The next node to build, or nothing when all are taken or one failed. Inner nodes first: they free
  /// memory.
  std::optional<uint32_t> take() {
    std::unique_lock lock(mutex_);
    while (true) {
      if (failure_ || done_ == built_.size()) return std::nullopt;
      if (!ready_.empty()) {
        const uint32_t number = ready_.top();
        ready_.pop();
        return number;
      }
      if (next_leaf_ < leaf_entries_.size()) return leaf_entries_[next_leaf_++];
      changed_.wait(lock);
    }
  }

  std::vector<BuiltNode> takeChildren(const Plan::Entry& entry) {
    std::lock_guard lock(mutex_);
    std::vector<BuiltNode> children;
    for (const uint32_t child : entry.children) {
      children.push_back(std::move(*built_[child]));
      built_[child].reset();
    }
    return children;
  }

  void give(uint32_t number, BuiltNode&& built) {
    std::lock_guard lock(mutex_);
    tree_.nodes[number] = built.node;
    tree_.payloads[number] = std::move(built.payloads);
    built_[number] = std::move(built);
    ++done_;
    const uint32_t parent = plan_.entries[number].parent;
    if (number + 1 < built_.size() && --waiting_for_[parent] == 0) ready_.push(parent);
    changed_.notify_all();
  }

  const Plan& plan_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::optional<BuiltNode>> built_;  ///< between a node's building and its parent's
  std::vector<size_t> waiting_for_;              ///< children not built yet
  std::priority_queue<uint32_t, std::vector<uint32_t>, std::greater<>> ready_;
  std::vector<uint32_t> leaf_entries_;
  size_t next_leaf_ = 0;
  size_t done_ = 0;
  SimplifiedTree tree_;
  std::exception_ptr failure_;
};

}  // namespace

SimplifiedTree simplify(const NodeBuilder::Settings& settings, const Partition& partition,
                        PayloadSpool& payloads, unsigned threads, const BuildProgress& progress) {
  const Plan plan(partition.leaves);
  Scheduler scheduler(plan);
  {
    std::vector<std::jthread> workers;
    for (unsigned i = 0; i < threads; ++i) {
      workers.emplace_back(
          [&] { scheduler.work([&] { return NodeBuilder(settings, partition, payloads); }); });
    }
    scheduler.waitUntilDone(progress);
  }
  payloads.flush();
  return scheduler.result();
}

}  // namespace lode::ingest
