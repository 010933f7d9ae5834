#include "server/ingest/nodes/node_spool.h"

#include <algorithm>

namespace lode::ingest {

NodeSpool::Place NodeSpool::append(const Node& node, std::span<const PayloadSpool::Place> payloads) {
  RecordWriter record;
  putFinishedNode(record, node, payloads);
  std::lock_guard lock(mutex_);
  const Place place{node.key, spool_.size(), static_cast<uint32_t>(record.bytes().size())};
  spool_.append(record.bytes());
  places_.push_back(place);
  return place;
}

std::vector<std::byte> NodeSpool::read(const Place& place) {
  std::vector<std::byte> bytes(place.bytes);
  {
    std::lock_guard lock(mutex_);
    if (place.offset + place.bytes > flushed_) {
      spool_.flush();
      flushed_ = spool_.size();
    }
  }
  spool_.readAt(place.offset, bytes);
  return bytes;
}

std::vector<NodeSpool::Place> NodeSpool::takeSorted() {
  std::lock_guard lock(mutex_);
  std::sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) { return a.key < b.key; });
  return std::move(places_);
}

}  // namespace lode::ingest
