#include "server/ingest/partition/partition.h"

#include <algorithm>

#include "common/error.h"
#include "server/ingest/partition/leaf_cutter.h"
#include "server/ingest/partition/leaf_mesh.h"
#include "server/ingest/partition/leaf_welder.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kMaxLeafFileBytes = 1ull << 62;

}  // namespace

NodeMesh Partition::readLeaf(uint32_t leaf) const {
  std::vector<std::byte> bytes(begin[leaf + 1] - begin[leaf]);
  meshes.readAt(begin[leaf], bytes);
  RecordReader record(bytes);
  return getLeaf(record, attributes);
}

void Partition::save(RecordWriter& record) const {
  meshes.sync();
  record.putAll(leaves);
  record.putAll(begin);
  record.putAll(digests);
  record.put(triangles);
  border.save(record);
}

Partition Partition::load(const TemporaryFolder& folder, AttributeSet attributes, RecordReader& record) {
  auto leaves = record.getAll<NodeKey>();
  auto begin = record.getAll<uint64_t>();
  auto digests = record.getAll<Digest>();
  if (leaves.empty() || begin.size() != leaves.size() + 1 || digests.size() != leaves.size() ||
      !std::is_sorted(begin.begin(), begin.end()) || begin.back() > kMaxLeafFileBytes) {
    throw Error(ErrorCode::kFormat, "the build's journal has a damaged partition; build without --resume");
  }
  const auto triangles = record.get<uint64_t>();
  Spool meshes = Spool::forReading(folder.path() / kLeafFile, begin.back());
  Partition result{attributes, std::move(leaves), std::move(begin),           std::move(digests),
                   triangles,  std::move(meshes), BorderTable(folder, record)};
  if (result.border.leafCount() != result.leaves.size()) {
    throw Error(ErrorCode::kFormat, "the build's journal has a damaged partition; build without --resume");
  }
  return result;
}

Partition partition(const PartitionInput& input) {
  RecordSorter& sorted = input.sorted;
  const BuildProgress& progress = input.progress;
  Partition result{input.attributes,
                   {},
                   {0},
                   {},
                   0,
                   Spool(input.folder.lastingFile(Partition::kLeafFile)),
                   BorderTable(input.folder, input.memory_bytes)};
  FixedHelpers helpers(input.threads - 1);
  LeafWelder welder(result.border, input.attributes, input.crease, helpers,
                    [&](std::span<const std::byte> mesh, const Digest& digest) {
                      result.meshes.append(mesh);
                      result.digests.push_back(digest);
                      result.begin.push_back(result.meshes.size());
                    });
  const auto takeLeaf = [&](NodeKey key, std::span<const std::byte> records, uint32_t triangles) {
    const auto leaf = static_cast<uint32_t>(result.leaves.size());
    result.leaves.push_back(key);
    result.triangles += triangles;
    welder.add(leaf, records);
    if (progress) {
      const auto done = result.triangles;
      progress("partition", static_cast<double>(done) / static_cast<double>(sorted.size()), done,
               sorted.size());
    }
  };
  LeafCutter cutter(soupBytes(input.attributes), input.triangles_per_node, takeLeaf);
  while (const auto record = sorted.next()) cutter.push(record->key, record->bytes);
  cutter.finish();
  welder.finish();
  result.meshes.flush();
  result.border.join(result.leaves, input.crease, [&](uint64_t done, uint64_t total) {
    if (progress) progress("border", static_cast<double>(done) / static_cast<double>(total), done, total);
  });
  return result;
}

}  // namespace lode::ingest
