#include <algorithm>
#include <array>
#include <string>

#include "common/error.h"
#include "server/ingest/nodes/lod_targets.h"
#include "server/ingest/nodes/tree_builder.h"
#include "server/ingest/pipeline/parts.h"
#include "server/ingest/pipeline/stages.h"
#include "server/ingest/pipeline/treelets_of_build.h"

namespace lode::ingest {
namespace {

/// Returns an upper bound on the number of triangles that the root's children pass to the root. The bound
/// grows with the number of locked vertices, which several leaves share.
uint64_t mostTrianglesOfRoot(const Partition& partition, uint32_t triangles_per_node) {
  std::array<bool, 8> has_leaves{};
  for (const NodeKey leaf : partition.leaves) has_leaves[leaf.ancestorAt(1).octant()] = true;
  uint64_t triangles = 0;
  for (size_t octant = 0; octant < has_leaves.size(); ++octant) {
    if (!has_leaves[octant]) continue;
    triangles += mostTriangles({.depth = 1,
                                .locked = partition.border.lockedBelowRoot()[octant],
                                .original_triangles = partition.triangles,
                                .triangles_per_node = triangles_per_node});
  }
  return std::min(triangles, partition.triangles);
}

}  // namespace

SimplifyStage::SimplifyStage(BuildSession& session, PartitionStage& partition)
    : Stage({.name = "simplify",
             .entry = BuildEntry::kSimplified,
             .used_up_by = BuildEntry::kPacked,
             .files = {kTreeletFolder}}),
      session_(session),
      partition_(partition) {}

void SimplifyStage::warnOfSmallMemory() {
  const BuildOptions& options = session_.options();
  const Partition& partition = partition_.partition();
  const bool is_one_node = partition.leaves.size() == 1;
  const std::string words = smallBudgetInWords(options.memory_bytes, options.triangles_per_node, is_one_node);
  if (!words.empty()) return session_.warn(words);
  if (is_one_node) return;
  const uint64_t root = mostTrianglesOfRoot(partition, options.triangles_per_node);
  const uint64_t root_bytes = memoryForLargeNode(root, session_.facts().payloadAttributes());
  if (options.memory_bytes < root_bytes)
    session_.warn(budgetBelowInWords(root_bytes, "a root of up to " + std::to_string(root) + " triangles"));
}

Stage::Work SimplifyStage::run() {
  warnOfSmallMemory();
  const BuildOptions& options = session_.options();
  const Partition& partition = partition_.partition();
  const TreeletsOfBuild work(session_.facts(), options, partition);
  TreeletFolder folder(session_.files().path() / kTreeletFolder, options.reuse_folder);
  if (options.part == BuildPart::kFinish) requireAllTasks(options, work.treelets, folder);
  buildTree(work.settings, partition,
            {.tree = work.tree,
             .treelets = work.treelets,
             .is_wanted = std::vector<bool>(work.treelets.size(), true),
             .folder = folder,
             .scratch = session_.files()},
            {session_.plan().threads, session_.plan().node_bytes}, session_.progress(), tree_);
  folder.sync();
  for (const Treelet& treelet : work.treelets.all()) treelets_.push_back(treelet.name);
  if (!options.reuse_folder.empty()) trimSharedTreelets(options.reuse_folder, options.reuse_bytes);
  partition_.release();
  return {tree_.size(), tree_.bytes()};
}

void SimplifyStage::load(RecordReader& record, bool is_used_up) {
  treelets_ = record.getAll<Digest>();
  if (is_used_up) return;
  const TreeletFolder folder(session_.files().path() / kTreeletFolder, {});
  for (const Digest& name : treelets_) {
    const std::optional<TreeletFile> file = folder.find(name);
    if (!file)
      throw Error(ErrorCode::kFormat,
                  "a finished part of the build is missing or damaged; build without --resume");
    tree_.add(*file);
  }
}

}  // namespace lode::ingest
