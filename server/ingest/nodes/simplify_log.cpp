#include "server/ingest/nodes/simplify_log.h"

#include <utility>

#include "common/codec/blob.h"

namespace lode::ingest {
namespace {

struct RootRecord {
  NodeKey key;
  FinishedNodes::Place place;
};

Spool openRoots(const TemporaryFolder& folder, uint64_t bytes) {
  const TemporaryFile file = folder.lastingFile(SimplifyLog::kRootFile);
  return bytes == 0 ? Spool(file) : Spool(file, bytes);
}

}  // namespace

void FinishedNodes::add(RecordReader& record) {
  payload_bytes = record.get<uint64_t>();
  root_bytes = record.get<uint64_t>();
  for (const RootRecord& root : record.getAll<RootRecord>()) {
    if (root.place.bytes > root_bytes || root.place.offset > root_bytes - root.place.bytes) {
      throw Error(ErrorCode::kFormat,
                  "the build journal refers to a missing subtree; build without --resume");
    }
    roots[root.key] = root.place;
  }
  const auto count = record.get<uint32_t>();
  for (uint32_t i = 0; i < count; ++i) {
    nodes.push_back(getFinishedNode(record));
    const Node& node = nodes.back().node;
    for (unsigned octant = 0; octant < 8; ++octant) {
      if (node.child_mask >> octant & 1) roots.erase(node.key.child(octant));
    }
  }
}

SimplifyLog::SimplifyLog(const TemporaryFolder& folder, PayloadSpool& payloads, FinishedNodes before,
                         Append append)
    : payloads_(payloads),
      before_(std::move(before)),
      append_(std::move(append)),
      roots_(openRoots(folder, before_.root_bytes)),
      clock_(CheckpointClock::Clock::now()) {}

BuiltNode SimplifyLog::readRoot(NodeKey key) const {
  const FinishedNodes::Place place = before_.roots.at(key);
  std::vector<std::byte> bytes(place.bytes);
  roots_.readAt(place.offset, bytes);
  if (checksum(bytes) != place.checksum) {
    throw Error(ErrorCode::kFormat, "the killed build's files are damaged; build without --resume");
  }
  RecordReader record(bytes);
  return getBuiltNode(record);
}

void SimplifyLog::addFinished(std::span<const std::byte> record) {
  if (finished_count_++ == 0) began_ = CheckpointClock::Clock::now();
  finished_.append(record);
}

void SimplifyLog::addRoot(const BuiltNode& built) {
  RecordWriter record;
  putBuiltNode(record, built);
  new_roots_.push_back({built.node.key, {roots_.size(), record.bytes().size(), checksum(record.bytes())}});
  roots_.append(record.bytes());
}

void SimplifyLog::write() {
  if (finished_count_ == 0) return;
  std::vector<RootRecord> roots;
  for (const auto& [key, place] : new_roots_) roots.push_back({key, place});
  RecordWriter entry;
  entry.put(payloads_.sync());
  roots_.flush();
  if (!roots.empty()) roots_.sync();
  entry.put(roots_.size());
  entry.putAll(roots);
  entry.put(finished_count_);
  entry.append(finished_.bytes());
  append_(entry.bytes());
  clock_.noted(began_, CheckpointClock::Clock::now());
  finished_count_ = 0;
  finished_ = {};
  new_roots_.clear();
}

}  // namespace lode::ingest
