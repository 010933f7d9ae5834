#include "server/ingest/nodes/built_tree.h"

#include <algorithm>

namespace lode::ingest {

void BuiltTree::add(const TreeletFile& file) {
  std::lock_guard lock(mutex_);
  const auto treelet = static_cast<uint32_t>(treelets_.size());
  treelets_.push_back(file.path());
  bytes_ += file.bytes();
  for (const NodePlace& node : file.nodes()) places_.push_back({node.key, treelet, node.record});
}

std::span<const BuiltTree::Place> BuiltTree::sorted() {
  std::sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) { return a.key < b.key; });
  return places_;
}

FinishedNode BuiltTree::read(const Place& place) {
  const std::vector<std::byte> bytes = reader_.read(treelets_[place.treelet], place.record);
  RecordReader record(bytes);
  return getFinishedNode(record);
}

std::vector<std::byte> BuiltTree::readPayload(const Place& node, PayloadPlace payload) {
  return reader_.read(treelets_[node.treelet], {payload.offset, payload.bytes});
}

}  // namespace lode::ingest
