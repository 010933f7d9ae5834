#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "server/ingest/disk/spool.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Stores the LODs of a large node on disk between simplification and measurement, because they do not fit
/// into memory beside the data of either step. Not thread safe. All functions throw Error kIo.
class LodSpool {
 public:
  explicit LodSpool(TemporaryFile file) : spool_(std::move(file)) {}

  void put(const SimplifiedMesh& lod);
  size_t size() const noexcept { return places_.size(); }
  /// Reads an LOD by its number in order of put(). @pre put() is not called after the first read().
  SimplifiedMesh read(size_t number);

 private:
  struct Place {
    uint64_t offset;
    AttributeSet attributes;
    size_t positions, wedges, wedge_attributes, triangles, remap;
    bool is_clustered;
  };

  Spool spool_;
  std::vector<Place> places_;
};

}  // namespace lode::ingest
