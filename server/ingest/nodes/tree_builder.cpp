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
#include <utility>

#include "common/error.h"
#include "common/release_storage.h"
#include "common/start_thread.h"
#include "server/ingest/plan/machine.h"
#include "server/ingest/plan/memory_plan.h"
#include "server/ingest/threads/helpers.h"

namespace lode::ingest {
namespace {

constexpr auto kProgressInterval = std::chrono::milliseconds(200);
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
  Scheduler(const TreeWork& work, const TreeResources& resources, uint32_t triangles_per_node,
            BuiltTree& built)
      : plan_(work.tree),
        treelets_(work.treelets),
        folder_(work.folder),
        tree_(built),
        memory_bytes_(resources.memory_bytes -
                      std::min(resources.memory_bytes, plan_.size() * kNodeRecordBytes)),
        leaf_bytes_(memoryOfNode(triangles_per_node)),
        built_(plan_.size()),
        is_given_(plan_.size()),
        input_triangles_(plan_.size()),
        waiting_for_(plan_.size()),
        finished_(treelets_.size()),
        open_(treelets_.size()) {}

  /// Takes over the finished treelets, and finds out which nodes can be built first.
  void prepare(const std::vector<bool>& is_wanted, const BuildProgress& progress) {
    takeOver(is_wanted, progress);
    taken_ = done_;
    for (uint32_t node = 0; node < plan_.size(); ++node) {
      if (is_given_[node]) continue;
      if (plan_.isLeaf(node)) {
        ++leaves_left_;
        continue;
      }
      for (const uint32_t child : plan_.children(node)) {
        if (!is_given_[child]) {
          ++waiting_for_[node];
        } else if (const auto& file = finished_[treelets_.treeletOf(child)]) {
          input_triangles_[node] += file->rootTriangles();
        }
      }
      if (waiting_for_[node] == 0) ready_.push(node);
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

  void finish() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  struct Taken {
    uint32_t number = 0;
    uint64_t bytes = 0;
    bool is_large = false;  ///< the node is large relative to the available memory
  };
  /// A treelet that is being written.
  struct OpenTreelet {
    explicit OpenTreelet(TreeletWriter&& its_writer) : writer(std::move(its_writer)) {}
    std::mutex mutex;  ///< guards the writer
    TreeletWriter writer;
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

  /// Marks the nodes that need not be built. @param is_wanted  see TreeWork.
  void takeOver(const std::vector<bool>& is_wanted, const BuildProgress& progress) {
    for (uint32_t i = 0; i < treelets_.size(); ++i) {
      const Treelet& treelet = treelets_[i];
      if (is_wanted[i]) finished_[i] = folder_.find(treelet.name);
      if (finished_[i] && finished_[i]->nodes().size() != treelet.nodes) finished_[i].reset();
      if (is_wanted[i] && !finished_[i]) continue;
      if (finished_[i]) tree_.add(*finished_[i]);
      done_ += treelet.nodes;
      if (progress && is_wanted[i]) tell(progress, done_);
    }
    for (uint32_t node = 0; node < plan_.size(); ++node) {
      const uint32_t treelet = treelets_.treeletOf(node);
      is_given_[node] = finished_[treelet] || !is_wanted[treelet];
    }
  }

  void tell(const BuildProgress& progress, size_t done) const {
    progress("simplify", static_cast<double>(done) / static_cast<double>(plan_.size()), done, plan_.size());
  }

  void reportProgress(const BuildProgress& progress, std::unique_lock<std::mutex>& lock) {
    if (!progress) return;
    const size_t done = done_;
    std::exception_ptr failure;
    lock.unlock();
    try {
      tell(progress, done);
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
    while (is_given_[next_leaf_] || !plan_.isLeaf(next_leaf_)) ++next_leaf_;
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

  /// Returns a node's children, and removes them from memory. Reads the roots of finished treelets.
  std::vector<BuiltNode> takeChildren(uint32_t number) {
    const std::vector<uint32_t> numbers = plan_.children(number);
    std::vector<BuiltNode> children(numbers.size());
    {
      std::lock_guard lock(mutex_);
      for (size_t i = 0; i < children.size(); ++i) {
        std::unique_ptr<BuiltNode>& built = built_[numbers[i]];
        if (!built) continue;
        held_bytes_ -= memoryOf(*built);
        children[i] = std::move(*built);
        built.reset();
      }
    }
    for (size_t i = 0; i < children.size(); ++i)
      if (is_given_[numbers[i]]) children[i] = rootOf(treelets_.treeletOf(numbers[i]));
    return children;
  }

  BuiltNode rootOf(uint32_t treelet) const {
    std::optional<TreeletFile> file = finished_[treelet];
    if (!file) file = folder_.find(treelets_[treelet].name);
    if (!file)
      throw Error(ErrorCode::kIo, "a finished part of the build has disappeared; run the build again");
    return file->readRoot();
  }

  void store(const Taken& taken, BuiltNode&& built) {
    const uint32_t number = taken.number;
    write(treelets_.treeletOf(number), number, built);
    auto waiting = std::make_unique<BuiltNode>(std::move(built));
    std::lock_guard lock(mutex_);
    held_bytes_ -= taken.bytes;
    ++done_;
    if (!plan_.isRoot(number) && !is_given_[plan_.parent(number)]) {
      const uint32_t parent = plan_.parent(number);
      input_triangles_[parent] += static_cast<uint32_t>(waiting->coarsest.triangles.size());
      if (--waiting_for_[parent] == 0) ready_.push(parent);
      held_bytes_ += memoryOf(*waiting);
      built_[number] = std::move(waiting);
    }
    changed_.notify_all();
  }

  /// Writes a node to its treelet, and completes the treelet after its root, which is built last. Frees the
  /// node's payloads.
  void write(uint32_t treelet, uint32_t number, BuiltNode& built) {
    OpenTreelet& open = openTreelet(treelet);
    {
      std::lock_guard lock(open.mutex);
      open.writer.add(built.node, built.payloads);
      releaseStorage(built.payloads);
    }
    if (treelets_[treelet].root != number) return;
    tree_.add(open.writer.finish(built));
    folder_.share(treelets_[treelet].name);
    std::lock_guard lock(mutex_);
    open_[treelet].reset();
  }

  OpenTreelet& openTreelet(uint32_t treelet) {
    std::lock_guard lock(mutex_);
    std::unique_ptr<OpenTreelet>& open = open_[treelet];
    if (!open) open = std::make_unique<OpenTreelet>(folder_.create(treelets_[treelet].name));
    return *open;
  }

  const TreePlan& plan_;
  const TreeletPlan& treelets_;
  TreeletFolder& folder_;
  BuiltTree& tree_;
  const uint64_t memory_bytes_, leaf_bytes_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::unique_ptr<BuiltNode>> built_;  ///< built nodes that their parents have not used yet
  std::vector<bool> is_given_;                     ///< true for each node that is finished or not wanted
  /// For each node, the number of triangles that its children built so far contribute to its input.
  std::vector<uint32_t> input_triangles_;
  std::vector<uint8_t> waiting_for_;  ///< number of children of each node that are not built yet
  std::vector<std::optional<TreeletFile>> finished_;  ///< treelets that were finished before
  std::vector<std::unique_ptr<OpenTreelet>> open_;    ///< treelets that are partly written
  std::priority_queue<uint32_t, std::vector<uint32_t>, std::greater<>> ready_;
  uint32_t next_leaf_ = 0;
  size_t leaves_left_ = 0, taken_ = 0, done_ = 0;
  size_t idle_ = 0;          ///< number of workers that wait for a node and help no other node
  uint64_t held_bytes_ = 0;  ///< estimated memory of the nodes being built and of the nodes in built_
  std::exception_ptr failure_;
};

}  // namespace

void buildTree(const NodeBuilder::Settings& settings, const Partition& partition, const TreeWork& work,
               const TreeResources& resources, const BuildProgress& progress, BuiltTree& built) {
  Scheduler scheduler(work, resources, settings.triangles_per_node, built);
  scheduler.prepare(work.is_wanted, progress);
  {
    const std::vector<std::jthread> workers = startThreads(resources.threads, "to simplify", [&] {
      scheduler.work([&] { return NodeBuilder(settings, partition, work.scratch); });
    });
    scheduler.waitUntilDone(progress);
  }
  scheduler.finish();
}

}  // namespace lode::ingest
