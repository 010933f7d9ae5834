#include "server/ingest/nodes/rung_shelf.h"

#include <span>

namespace lode::ingest {

void RungShelf::put(const SimplifiedMesh& rung) {
  // Named one by one, so that a member more does not compile.
  const auto& [mesh, became, is_clustered] = rung;
  const auto& [attributes, positions, lca_depth, wedge_position, wedge_attributes, triangles] = mesh;
  places_.push_back({spool_.size(), attributes, positions.size(), wedge_position.size(),
                     wedge_attributes.size(), triangles.size(), became.size(), is_clustered});
  const auto append = [&](const auto& items) { spool_.append(std::as_bytes(std::span(items))); };
  append(positions);
  append(lca_depth);
  append(wedge_position);
  append(wedge_attributes);
  append(triangles);
  append(became);
}

SimplifiedMesh RungShelf::read(size_t number) {
  spool_.flush();
  const Place& place = places_[number];
  uint64_t offset = place.offset;
  const auto read = [&](auto& items, size_t count) {
    items.resize(count);
    spool_.readAt(offset, std::as_writable_bytes(std::span(items)));
    offset += count * sizeof(items[0]);
  };
  SimplifiedMesh rung;
  rung.is_clustered = place.is_clustered;
  rung.mesh.attributes = place.attributes;
  read(rung.mesh.positions, place.positions);
  read(rung.mesh.lca_depth, place.positions);
  read(rung.mesh.wedge_position, place.wedges);
  read(rung.mesh.wedge_attributes, place.wedge_attributes);
  read(rung.mesh.triangles, place.triangles);
  read(rung.became, place.became);
  return rung;
}

}  // namespace lode::ingest
