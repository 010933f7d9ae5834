#include "server/ingest/nodes/lod_spool.h"

#include <span>

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

}  // namespace lode::ingest
