#include "server/ingest/inspect/lod_errors.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "common/start_thread.h"
#include "server/store/export.h"
#include "server/store/open_edges.h"

namespace lode::ingest {
namespace {

/// The LODs of one node that are to be measured. They are in memory only while the leaves below the node are
/// read.
struct NodeCheck {
  const Node* node = nullptr;
  uint64_t original = 0;       ///< number of triangles in the leaves below the node
  std::vector<size_t> wanted;  ///< for each LOD, its index in the list of results
  std::once_flag begun;
  std::vector<std::unique_ptr<LodCheck>> lods;
  BoundaryCheck boundaries;
  std::atomic<size_t> leaves_left = 0;
};

/// Returns the Morton code of the first cell at maximum depth inside a node.
uint64_t placeOf(NodeKey key) noexcept { return key.value << 3 * (kMaxDepth - key.depth()); }

class Measurement {
 public:
  Measurement(const store::Reader& reader, std::span<const LodAt> lods, const LodErrorOptions& options)
      : reader_(reader), wanted_(lods), options_(options), errors_(lods.size()) {
    for (size_t i = 0; i < lods.size(); ++i) {
      NodeCheck& check = checks_[lods[i].node->key.value];
      check.node = lods[i].node;
      check.wanted.push_back(i);
    }
    for (const Node& node : reader.nodes()) {
      if (!node.isLeaf()) continue;
      leaves_.push_back(&node);
      forEachAbove(node, [&](NodeCheck& check) {
        check.original += node.lods[0].triangles;
        ++check.leaves_left;
      });
    }
    std::sort(leaves_.begin(), leaves_.end(),
              [](const Node* a, const Node* b) { return placeOf(a->key) < placeOf(b->key); });
  }

  std::vector<MeasuredError> run() {
    startThreads(std::max(1u, options_.threads), "to measure", [this] { work(); }).clear();
    if (failure_) std::rethrow_exception(failure_);
    return std::move(errors_);
  }

 private:
  void work() noexcept {
    try {
      for (size_t i = next_++; i < leaves_.size() && !is_failed_; i = next_++) measure(*leaves_[i]);
    } catch (...) {
      std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
      is_failed_ = true;
    }
  }

  void measure(const Node& leaf) {
    const Mesh mesh = store::readLod(reader_, leaf, 0);
    const LeafSurface surface(mesh);
    store::OpenEdges boundaries;
    boundaries.add(mesh);
    forEachAbove(leaf, [&](NodeCheck& check) {
      std::call_once(check.begun, [&] { begin(check); });
      for (const std::unique_ptr<LodCheck>& lod : check.lods) lod->add(surface);
      check.boundaries.addLeaf(boundaries.edges());
      if (--check.leaves_left == 0) end(check);
    });
    std::lock_guard lock(mutex_);
    ++done_;
    if (options_.progress)
      options_.progress(static_cast<double>(done_) / static_cast<double>(leaves_.size()), done_);
  }

  float storedSteps(const LodAt& lod) const {
    return static_cast<float>(lod.node->lods[lod.lod].error_model / reader_.summary().lattice.step);
  }

  void begin(NodeCheck& check) const {
    for (const size_t i : check.wanted) {
      const Mesh lod = store::readLod(reader_, *check.node, wanted_[i].lod);
      check.lods.push_back(std::make_unique<LodCheck>(lod, check.node->box, storedSteps(wanted_[i]),
                                                      check.original, options_.seed + i));
      check.boundaries.addLod(lod);
    }
  }

  void end(NodeCheck& check) {
    const std::vector<FarPoint> boundaries = check.boundaries.farthest();
    for (size_t i = 0; i < check.wanted.size(); ++i) {
      FarPoint farthest = check.lods[i]->farthest();
      farthest.raiseTo(boundaries[i]);
      errors_[check.wanted[i]] = {storedSteps(wanted_[check.wanted[i]]), farthest};
    }
    check.lods.clear();
  }

  template <typename Visit>
  void forEachAbove(const Node& leaf, Visit&& visit) {
    for (int depth = leaf.key.depth(); depth >= 0; --depth) {
      const auto at = checks_.find(leaf.key.ancestorAt(depth).value);
      if (at != checks_.end()) visit(at->second);
    }
  }

  const store::Reader& reader_;
  const std::span<const LodAt> wanted_;
  const LodErrorOptions& options_;
  std::vector<MeasuredError> errors_;
  std::unordered_map<uint64_t, NodeCheck> checks_;
  std::vector<const Node*> leaves_;
  std::atomic<size_t> next_ = 0;
  std::atomic<bool> is_failed_ = false;
  std::mutex mutex_;
  uint64_t done_ = 0;
  std::exception_ptr failure_;
};

}  // namespace

std::vector<MeasuredError> measureLodErrors(const store::Reader& reader, std::span<const LodAt> lods,
                                            const LodErrorOptions& options) {
  return Measurement(reader, lods, options).run();
}

}  // namespace lode::ingest
