#include "server/ingest/nodes/tree_builder.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <queue>
#include <thread>
#include <unordered_map>

#include "common/error.h"

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
  Scheduler(const Plan& plan, SimplifyLog& log, unsigned threads)
      : plan_(plan),
        log_(log),
        threads_(threads),
        built_(plan.entries.size()),
        noted_(plan.entries.size()),
        waiting_for_(plan.entries.size()) {
    tree_.nodes.resize(plan.entries.size());
    tree_.payloads.resize(plan.entries.size());
    takeOverFinished();
    taken_ = done_;
    for (uint32_t i = 0; i < plan.entries.size(); ++i) {
      if (noted_[i]) continue;
      const std::vector<uint32_t>& children = plan.entries[i].children;
      waiting_for_[i] = static_cast<size_t>(
          std::count_if(children.begin(), children.end(), [&](uint32_t child) { return !noted_[child]; }));
      if (children.empty()) {
        leaf_entries_.push_back(i);
      } else if (waiting_for_[i] == 0) {
        ready_.push(i);
      }
    }
  }

  template <typename MakeBuilder>
  void work(MakeBuilder&& make_builder) noexcept {
    try {
      NodeBuilder builder = make_builder();
      while (const auto taken = take()) {
        const Plan::Entry& entry = plan_.entries[taken->number];
        if (entry.children.empty()) {
          give(*taken, builder.buildLeaf(entry.leaf, taken->lent));
        } else {
          std::vector<BuiltNode> children = takeChildren(entry);
          give(*taken, builder.buildInner(entry.key, children, taken->lent));
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
      const bool is_noting = log_.isDue();
      if (!progress && !is_noting) continue;
      const size_t done = done_;
      std::exception_ptr failure;
      try {
        if (is_noting) collectFinished();
        lock.unlock();
        if (is_noting) log_.write();
        if (progress) {
          progress("simplify", static_cast<double>(done) / static_cast<double>(built_.size()), done,
                   built_.size());
        }
      } catch (...) {
        failure = std::current_exception();
      }
      if (!lock.owns_lock()) lock.lock();
      if (failure && !failure_) failure_ = failure;
    }
    changed_.notify_all();
  }

  SimplifiedTree result() {
    if (failure_) std::rethrow_exception(failure_);
    collectFinished();
    log_.write();
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
  struct Taken {
    uint32_t number = 0;
    unsigned lent = 0;  ///< threads that find nothing to do now, for this node until it is given
  };

  /// The next node to build, or nothing when all are taken or one failed. Inner nodes first: they free
  /// memory.
  std::optional<Taken> take() {
    std::unique_lock lock(mutex_);
    while (true) {
      if (failure_ || done_ == built_.size()) return std::nullopt;
      if (!ready_.empty()) {
        const uint32_t number = ready_.top();
        ready_.pop();
        return Taken{number, lendToNext()};
      }
      if (next_leaf_ < leaf_entries_.size()) return Taken{leaf_entries_[next_leaf_++], lendToNext()};
      changed_.wait(lock);
    }
  }

  /// To the node that is taken now. @return none while there are nodes for all threads.
  unsigned lendToNext() {
    const size_t under_way = ++taken_ - done_;
    const size_t busy = under_way + ready_.size() + (leaf_entries_.size() - next_leaf_) + lent_;
    const unsigned idle = busy < threads_ ? static_cast<unsigned>(threads_ - busy) : 0;
    lent_ += idle;
    return idle;
  }

  std::vector<BuiltNode> takeChildren(const Plan::Entry& entry) {
    std::unique_lock lock(mutex_);
    std::vector<BuiltNode> children(entry.children.size());
    for (size_t i = 0; i < children.size(); ++i) {
      auto& built = built_[entry.children[i]];
      if (!built) continue;
      children[i] = std::move(*built);
      built.reset();
    }
    lock.unlock();
    for (size_t i = 0; i < children.size(); ++i) {
      if (children[i].node.rungs.empty()) children[i] = log_.readRoot(plan_.entries[entry.children[i]].key);
    }
    return children;
  }

  /// What a killed build had finished; its meshes stay on the disk until they are needed.
  void takeOverFinished() {
    std::unordered_map<uint64_t, uint32_t> numbers;
    for (uint32_t i = 0; i < plan_.entries.size(); ++i) numbers.emplace(plan_.entries[i].key.value, i);
    for (const FinishedNode& finished : log_.before().nodes) {
      const auto at = numbers.find(finished.node.key.value);
      if (at == numbers.end() || noted_[at->second]) failResume();
      noted_[at->second] = true;
      tree_.nodes[at->second] = finished.node;
      tree_.payloads[at->second] = finished.payloads;
      ++done_;
    }
    for (uint32_t i = 0; i < plan_.entries.size(); ++i) {
      const Plan::Entry& entry = plan_.entries[i];
      const bool is_open = noted_[i] && i + 1 < plan_.entries.size() && !noted_[entry.parent];
      if (is_open && !log_.before().roots.contains(entry.key)) failResume();
    }
  }

  [[noreturn]] static void failResume() {
    throw Error(ErrorCode::kFormat,
                "the journal of a build names nodes of another tree; build without --resume");
  }

  /// Gives the log those nodes that another build could go on from: a node's parent is among them, or has not
  /// taken it yet, so that what it needs of it can be kept. A leaf is built again rather than kept.
  void collectFinished() {
    std::sort(finished_.begin(), finished_.end(), std::greater<>());  // parents before children
    std::vector<uint32_t> left;
    for (const uint32_t number : finished_) {
      const Plan::Entry& entry = plan_.entries[number];
      const bool is_root = number + 1 == plan_.entries.size();
      const bool is_below_noted = is_root || noted_[entry.parent];
      if (!is_below_noted && (entry.children.empty() || !built_[number])) {
        left.push_back(number);
        continue;
      }
      noted_[number] = true;
      if (!is_below_noted) log_.addRoot(*built_[number]);
      log_.addFinished(tree_.nodes[number], tree_.payloads[number]);
    }
    finished_ = std::move(left);
  }

  void give(const Taken& taken, BuiltNode&& built) {
    const uint32_t number = taken.number;
    std::lock_guard lock(mutex_);
    lent_ -= taken.lent;
    tree_.nodes[number] = built.node;
    tree_.payloads[number] = built.payloads;
    built_[number] = std::move(built);
    finished_.push_back(number);
    ++done_;
    const uint32_t parent = plan_.entries[number].parent;
    if (number + 1 < built_.size() && --waiting_for_[parent] == 0) ready_.push(parent);
    changed_.notify_all();
  }

  const Plan& plan_;
  SimplifyLog& log_;
  const unsigned threads_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::optional<BuiltNode>> built_;  ///< between a node's building and its parent's
  std::vector<uint32_t> finished_;               ///< and not in the log
  std::vector<bool> noted_;                      ///< in the log
  std::vector<size_t> waiting_for_;              ///< children not built yet
  std::priority_queue<uint32_t, std::vector<uint32_t>, std::greater<>> ready_;
  std::vector<uint32_t> leaf_entries_;
  size_t next_leaf_ = 0;
  size_t taken_ = 0, done_ = 0, lent_ = 0;
  SimplifiedTree tree_;
  std::exception_ptr failure_;
};

}  // namespace

SimplifiedTree treeOf(FinishedNodes finished) {
  std::sort(finished.nodes.begin(), finished.nodes.end(),
            [](const FinishedNode& a, const FinishedNode& b) { return a.node.key < b.node.key; });
  SimplifiedTree tree;
  for (FinishedNode& node : finished.nodes) {
    tree.nodes.push_back(std::move(node.node));
    tree.payloads.push_back(std::move(node.payloads));
  }
  return tree;
}

SimplifiedTree simplify(const NodeBuilder::Settings& settings, const Partition& partition,
                        PayloadSpool& payloads, SimplifyLog& log, unsigned threads,
                        const BuildProgress& progress) {
  const Plan plan(partition.leaves);
  Scheduler scheduler(plan, log, threads);
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
