#include "server/ingest/nodes/node_spool.h"

#include <algorithm>

#include "server/ingest/nodes/built_node_record.h"

namespace lode::ingest {

void LodSpool::put(const SimplifiedMesh& lod) {
  // Name all members, so that this code does not compile after a member is added.
  const auto& [mesh, remap, is_clustered] = lod;
  const auto& [attributes, positions, lca_depth, wedge_position, wedge_attributes, triangles] = mesh;
  places_.push_back({spool_.size(), attributes, positions.size(), wedge_position.size(),
                     wedge_attributes.size(), triangles.size(), remap.size(), is_clustered});
  const auto append = [&](const auto& items) { spool_.append(std::as_bytes(std::span(items))); };
  append(positions);
  append(lca_depth);
  append(wedge_position);
  append(wedge_attributes);
  append(triangles);
  append(remap);
}

SimplifiedMesh LodSpool::read(size_t number) {
  spool_.flush();
  const Place& place = places_[number];
  uint64_t offset = place.offset;
  const auto read = [&](auto& items, size_t count) {
    items.resize(count);
    spool_.readAt(offset, std::as_writable_bytes(std::span(items)));
    offset += count * sizeof(items[0]);
  };
  SimplifiedMesh lod;
  lod.is_clustered = place.is_clustered;
  lod.mesh.attributes = place.attributes;
  read(lod.mesh.positions, place.positions);
  read(lod.mesh.lca_depth, place.positions);
  read(lod.mesh.wedge_position, place.wedges);
  read(lod.mesh.wedge_attributes, place.wedge_attributes);
  read(lod.mesh.triangles, place.triangles);
  read(lod.remap, place.remap);
  return lod;
}

PayloadSpool::Place PayloadSpool::append(std::span<const std::byte> payload) {
  std::lock_guard lock(mutex_);
  const Place place{spool_.size(), static_cast<uint32_t>(payload.size())};
  spool_.append(payload);
  return place;
}

uint64_t PayloadSpool::sync() {
  std::unique_lock lock(mutex_);
  spool_.flush();
  const uint64_t bytes = spool_.size();
  lock.unlock();
  spool_.sync();
  return bytes;
}

std::vector<std::byte> PayloadSpool::read(Place place) const {
  std::vector<std::byte> payload(place.bytes);
  spool_.readAt(place.offset, payload);
  return payload;
}

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
