#include "server/ingest/nodes/tree_builder.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <queue>
#include <thread>
#include <unordered_map>

#include "common/error.h"
#include "common/start_thread.h"
#include "server/ingest/nodes/tree_plan.h"
#include "server/ingest/plan/machine.h"
#include "server/ingest/plan/memory_plan.h"
#include "server/ingest/threads/helpers.h"

namespace lode::ingest {
namespace {

constexpr auto kProgressInterval = std::chrono::milliseconds(200);
constexpr uint32_t kNoNode = ~0u;
constexpr uint64_t kLargeShare = 2;  ///< a node that takes more than half of the memory is large

uint64_t memoryOf(const BuiltNode& built) noexcept {
  const auto bytesOf = [](const auto& items) { return items.capacity() * sizeof(items[0]); };
  const NodeMesh& mesh = built.coarsest;
  return sizeof(BuiltNode) + bytesOf(built.samples) + bytesOf(built.references.boundaries) +
         bytesOf(mesh.positions) + bytesOf(mesh.lca_depth) + bytesOf(mesh.wedge_position) +
         bytesOf(mesh.wedge_attributes) + bytesOf(mesh.triangles);
}

/// Shared state of the workers. The mutex guards everything that changes.
class Scheduler {
 public:
  Scheduler(const TreePlan& plan, SimplifyLog& log, NodeSpool& nodes, const TreeResources& resources,
            uint32_t triangles_per_node)
      : plan_(plan),
        log_(log),
        nodes_(nodes),
        memory_bytes_(resources.memory_bytes -
                      std::min(resources.memory_bytes, plan.size() * kNodeRecordBytes)),
        leaf_bytes_(memoryOfNode(triangles_per_node)),
        built_(plan.size()),
        logged_(plan.size()),
        input_triangles_(plan.size()),
        waiting_for_(plan.size()) {
    nodes.reserve(plan.size());
    resume();
    taken_ = done_;
    for (uint32_t i = 0; i < plan.size(); ++i) {
      if (logged_[i]) continue;
      const std::vector<uint32_t> children = plan.children(i);
      waiting_for_[i] = static_cast<uint8_t>(
          std::count_if(children.begin(), children.end(), [&](uint32_t child) { return !logged_[child]; }));
      if (children.empty()) {
        ++leaves_left_;
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
        if (taken->is_large) trimHeap();
        store(*taken, build(builder, *taken));
      }
    } catch (...) {
      std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
      changed_.notify_all();
    }
  }

  /// Waits until all nodes are built, or until a worker or `progress` has thrown. Reports progress at least
  /// once.
  void waitUntilDone(const BuildProgress& progress) {
    std::unique_lock lock(mutex_);
    reportProgress(progress, lock);
    while (done_ < plan_.size() && !failure_) {
      changed_.wait_for(lock, kProgressInterval);
      reportProgress(progress, lock);
    }
    changed_.notify_all();
  }

  void finish() {
    if (failure_) std::rethrow_exception(failure_);
    writeLog();
  }

 private:
  struct Taken {
    uint32_t number = 0;
    uint64_t bytes = 0;
    bool is_large = false;  ///< the node is large relative to the available memory
  };
  struct Finished {
    uint32_t number = 0;
    NodeSpool::Place place;
  };
  /// Lends idle workers to a node, as far as memory allows.
  class IdleWorkers final : public Helpers {
   public:
    IdleWorkers(Scheduler& scheduler, uint64_t bytes) : scheduler_(scheduler), bytes_(bytes) {}
    bool take() override { return scheduler_.lend(bytes_); }
    void release() override { scheduler_.takeBack(bytes_); }

   private:
    Scheduler& scheduler_;
    const uint64_t bytes_;
  };

  void reportProgress(const BuildProgress& progress, std::unique_lock<std::mutex>& lock) {
    const bool is_logging = log_.isDue();
    if (!progress && !is_logging) return;
    const size_t done = done_;
    std::exception_ptr failure;
    lock.unlock();
    try {
      if (is_logging) writeLog();
      if (progress)
        progress("simplify", static_cast<double>(done) / static_cast<double>(plan_.size()), done,
                 plan_.size());
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (failure && !failure_) failure_ = failure;
  }

  /// Waits for a node that fits into memory, and returns the node. Returns nothing if all nodes are built or
  /// a worker has failed.
  std::optional<Taken> take() {
    std::unique_lock lock(mutex_);
    ++idle_;
    while (!failure_ && done_ < plan_.size()) {
      if (idle_ > 0) {  // if idle_ is 0, all waiting workers (this one too) are lent to other nodes
        if (const std::optional<Taken> next = nextWithRoom()) return next;
      }
      changed_.wait(lock);
    }
    return std::nullopt;
  }

  /// Chooses the next node that fits into memory. Prefers inner nodes, because building them frees memory.
  std::optional<Taken> nextWithRoom() {
    if (!ready_.empty()) {
      const uint32_t number = ready_.top();
      const uint64_t bytes = memoryOfNode(input_triangles_[number]);
      if (!hasRoomFor(bytes)) return std::nullopt;
      ready_.pop();
      return started(number, bytes);
    }
    if (leaves_left_ == 0 || !hasRoomFor(leaf_bytes_)) return std::nullopt;
    while (logged_[next_leaf_] || !plan_.isLeaf(next_leaf_)) ++next_leaf_;
    --leaves_left_;
    return started(next_leaf_++, leaf_bytes_);
  }

  /// Returns true if a node fits into memory. A node that is built alone may exceed the memory.
  bool hasRoomFor(uint64_t bytes) const noexcept {
    return taken_ == done_ || held_bytes_ + bytes <= memory_bytes_;
  }

  Taken started(uint32_t number, uint64_t bytes) {
    --idle_;
    held_bytes_ += bytes;
    ++taken_;
    return {number, bytes, bytes > memory_bytes_ / kLargeShare};
  }

  bool lend(uint64_t bytes) {
    std::lock_guard lock(mutex_);
    if (idle_ == 0 || held_bytes_ + bytes > memory_bytes_) return false;
    --idle_;
    held_bytes_ += bytes;
    return true;
  }

  void takeBack(uint64_t bytes) {
    std::lock_guard lock(mutex_);
    ++idle_;
    held_bytes_ -= bytes;
    changed_.notify_all();
  }

  BuiltNode build(NodeBuilder& builder, const Taken& taken) {
    IdleWorkers helpers(*this, taken.bytes);
    const NodeBuilder::Room room{helpers, taken.is_large};
    if (plan_.isLeaf(taken.number)) return builder.buildLeaf(plan_.leaf(taken.number), room);
    std::vector<BuiltNode> children = takeChildren(taken.number);
    return builder.buildInner(plan_.key(taken.number), children, room);
  }

  std::vector<BuiltNode> takeChildren(uint32_t number) {
    const std::vector<uint32_t> numbers = plan_.children(number);
    std::vector<BuiltNode> children(numbers.size());
    std::unique_lock lock(mutex_);
    for (size_t i = 0; i < children.size(); ++i) {
      changed_.wait(lock, [&] { return being_logged_ != numbers[i] || failure_; });
      std::unique_ptr<BuiltNode>& built = built_[numbers[i]];
      if (!built) continue;
      held_bytes_ -= memoryOf(*built);
      children[i] = std::move(*built);
      built.reset();
    }
    lock.unlock();
    for (size_t i = 0; i < children.size(); ++i) {
      if (children[i].node.lods.empty()) children[i] = log_.readRoot(plan_.key(numbers[i]));
    }
    return children;
  }

  /// Restores the nodes that a killed build had finished. The nodes' meshes stay on disk until their parents
  /// need them.
  void resume() {
    const std::vector<FinishedNode> before = log_.takeFinished();
    if (before.empty()) return;
    std::unordered_map<uint64_t, uint32_t> numbers;
    for (uint32_t i = 0; i < plan_.size(); ++i) numbers.emplace(plan_.key(i).value, i);
    for (const FinishedNode& finished : before) {
      const auto at = numbers.find(finished.node.key.value);
      if (at == numbers.end() || logged_[at->second]) failResume();
      logged_[at->second] = true;
      nodes_.append(finished.node, finished.payloads);
      if (!plan_.isRoot(at->second))
        input_triangles_[plan_.parent(at->second)] += finished.node.sourceLod().triangles;
      ++done_;
    }
    for (uint32_t i = 0; i < plan_.size(); ++i) {
      const bool is_open = logged_[i] && !plan_.isRoot(i) && !logged_[plan_.parent(i)];
      if (is_open && !log_.hasRoot(plan_.key(i))) failResume();
    }
  }

  [[noreturn]] static void failResume() {
    throw Error(ErrorCode::kFormat, "the build journal belongs to another tree; build without --resume");
  }

  /// Logs the finished nodes that a resumed build can use. These are nodes with a logged parent, and inner
  /// nodes whose parent is not built yet, together with the data that the parent needs. Logs a leaf only
  /// after its parent, so a resumed build may rebuild leaves. Workers wait for the disk only if they need the
  /// node that is being written.
  void writeLog() {
    std::vector<Finished> finished;
    {
      std::lock_guard lock(mutex_);
      finished.swap(finished_);
    }
    std::sort(finished.begin(), finished.end(),
              [](const Finished& a, const Finished& b) { return a.number > b.number; });  // parents first
    std::vector<Finished> left;
    for (const Finished& node : finished) {
      if (tryToLogBelowParent(node.number) || tryToLogRoot(node.number)) {
        log_.addFinished(nodes_.read(node.place));
      } else {
        left.push_back(node);
      }
    }
    log_.write();
    std::lock_guard lock(mutex_);
    finished_.insert(finished_.end(), left.begin(), left.end());
  }

  bool tryToLogBelowParent(uint32_t number) {
    std::lock_guard lock(mutex_);
    const bool is_below = plan_.isRoot(number) || logged_[plan_.parent(number)];
    if (is_below) logged_[number] = true;
    return is_below;
  }

  /// Logs a node as the root of a finished subtree. @return false if the node is a leaf, or if its parent has
  /// used it.
  bool tryToLogRoot(uint32_t number) {
    if (plan_.isLeaf(number)) return false;
    std::unique_ptr<BuiltNode> root;
    {
      std::lock_guard lock(mutex_);
      if (!built_[number]) return false;
      root = std::move(built_[number]);
      being_logged_ = number;
      logged_[number] = true;
    }
    log_.addRoot(*root);
    {
      std::lock_guard lock(mutex_);
      built_[number] = std::move(root);
      being_logged_ = kNoNode;
    }
    changed_.notify_all();
    return true;
  }

  void store(const Taken& taken, BuiltNode&& built) {
    const uint32_t number = taken.number;
    const NodeSpool::Place place = nodes_.append(built.node, built.payloads);
    auto waiting = std::make_unique<BuiltNode>(std::move(built));
    std::lock_guard lock(mutex_);
    held_bytes_ += memoryOf(*waiting);
    held_bytes_ -= taken.bytes;
    finished_.push_back({number, place});
    ++done_;
    if (!plan_.isRoot(number)) {
      const uint32_t parent = plan_.parent(number);
      input_triangles_[parent] += static_cast<uint32_t>(waiting->coarsest.triangles.size());
      if (--waiting_for_[parent] == 0) ready_.push(parent);
    }
    built_[number] = std::move(waiting);
    changed_.notify_all();
  }

  const TreePlan& plan_;
  SimplifyLog& log_;
  NodeSpool& nodes_;
  const uint64_t memory_bytes_, leaf_bytes_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::unique_ptr<BuiltNode>> built_;  ///< built nodes that their parents have not used yet
  std::vector<Finished> finished_;                 ///< built nodes that the journal does not contain yet
  std::vector<bool> logged_;                       ///< true for each node that the journal contains
  uint32_t being_logged_ = kNoNode;  ///< node that the journal writes now, temporarily moved out of built_
  /// For each node, the number of triangles that its children built so far contribute to its input.
  std::vector<uint32_t> input_triangles_;
  std::vector<uint8_t> waiting_for_;  ///< number of children of each node that are not built yet
  std::priority_queue<uint32_t, std::vector<uint32_t>, std::greater<>> ready_;
  uint32_t next_leaf_ = 0;
  size_t leaves_left_ = 0, taken_ = 0, done_ = 0;
  size_t idle_ = 0;          ///< number of workers that wait for a node and help no other node
  uint64_t held_bytes_ = 0;  ///< estimated memory of the nodes being built and of the nodes in built_
  std::exception_ptr failure_;
};

}  // namespace

void buildTree(const NodeBuilder::Settings& settings, const Partition& partition, const TreeFiles& files,
               const TreeResources& resources, const BuildProgress& progress) {
  const TreePlan plan(partition.leaves);
  Scheduler scheduler(plan, files.log, files.nodes, resources, settings.triangles_per_node);
  {
    const std::vector<std::jthread> workers = startThreads(resources.threads, "to simplify", [&] {
      scheduler.work([&] { return NodeBuilder(settings, partition, files.payloads, files.folder); });
    });
    scheduler.waitUntilDone(progress);
  }
  files.payloads.flush();
  scheduler.finish();
}

}  // namespace lode::ingest
