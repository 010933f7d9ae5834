#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "server/ingest/disk/spool.h"
#include "server/ingest/mesh/simplified_mesh.h"

namespace lode::ingest {

/// LODs of a node on the disk, from when the simplifier has made them until they are measured: a large
/// node's would not fit beside either. For one thread. All functions throw Error kIo.
class LodShelf {
 public:
  explicit LodShelf(TemporaryFile file) : spool_(std::move(file)) {}

  void put(const SimplifiedMesh& lod);
  size_t size() const noexcept { return places_.size(); }
  /// Those that were put, by their order. @pre nothing is put after the first call.
  SimplifiedMesh read(size_t number);

 private:
  struct Place {
    uint64_t offset;
    AttributeSet attributes;
    size_t positions, wedges, wedge_attributes, triangles, became;
    bool is_clustered;
  };

  Spool spool_;
  std::vector<Place> places_;
};

}  // namespace lode::ingest
