#include "server/ingest/partition.h"

#include <algorithm>

#include "common/error.h"
#include "server/ingest/border_finder.h"
#include "server/ingest/leaf_cutter.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kMaxSoupFileBytes = 1ull << 62;

}  // namespace

std::vector<std::byte> Partition::readLeaf(uint32_t leaf) const {
  const size_t record_bytes = soupBytes(attributes);
  std::vector<std::byte> records((first[leaf + 1] - first[leaf]) * record_bytes);
  soup.readAt(first[leaf] * record_bytes, records);
  return records;
}

void Partition::save(RecordWriter& record) const {
  soup.sync();
  record.putAll(leaves);
  record.putAll(first);
  border.save(record);
}

Partition Partition::load(const TemporaryFolder& folder, AttributeSet attributes, RecordReader& record) {
  auto leaves = record.getAll<NodeKey>();
  auto first = record.getAll<uint64_t>();
  if (leaves.empty() || first.size() != leaves.size() + 1 || !std::is_sorted(first.begin(), first.end()) ||
      first.back() > kMaxSoupFileBytes / soupBytes(attributes)) {
    throw Error(ErrorCode::kFormat, "the journal of a build names no partition; build without --resume");
  }
  Spool soup(folder.lastingFile(kSoupFile), first.back() * soupBytes(attributes));
  Partition result{attributes, std::move(leaves), std::move(first), std::move(soup),
                   BorderTable(folder, record)};
  if (result.border.leafCount() != result.leaves.size()) {
    throw Error(ErrorCode::kFormat, "the journal of a build names no partition; build without --resume");
  }
  return result;
}

Partition partition(RecordSorter& sorted, AttributeSet attributes, uint32_t triangles_per_node,
                    uint64_t memory_bytes, unsigned threads, const TemporaryFolder& folder,
                    const BuildProgress& progress) {
  Partition result{attributes,
                   {},
                   {0},
                   Spool(folder.lastingFile(Partition::kSoupFile)),
                   BorderTable(folder, memory_bytes)};
  BorderFinder finder(result.border, attributes, threads);
  const auto takeLeaf = [&](NodeKey key, std::span<const std::byte> records, uint32_t triangles) {
    const auto leaf = static_cast<uint32_t>(result.leaves.size());
    result.leaves.push_back(key);
    result.first.push_back(result.first.back() + triangles);
    result.soup.append(records);
    finder.add(leaf, records);
    if (progress) {
      const auto done = result.first.back();
      progress("partition", static_cast<double>(done) / static_cast<double>(sorted.size()), done,
               sorted.size());
    }
  };
  LeafCutter cutter(soupBytes(attributes), triangles_per_node, takeLeaf);
  while (const auto record = sorted.next()) cutter.push(record->key, record->bytes);
  cutter.finish();
  finder.finish();
  result.soup.flush();
  result.border.join(result.leaves, [&](uint64_t done, uint64_t total) {
    if (progress) progress("border", static_cast<double>(done) / static_cast<double>(total), done, total);
  });
  return result;
}

}  // namespace lode::ingest
