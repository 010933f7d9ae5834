#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/disk/temporary_folder.h"

namespace lode::ingest {

/// Finds vertices at exactly the position of an earlier vertex, by sorting in bounded memory. Not thread
/// safe. All functions throw Error kIo.
class SamePlaces {
 public:
  SamePlaces(const TemporaryFolder& folder, uint64_t memory_bytes);

  /// @pre vertices are added in ascending order.
  void add(uint32_t vertex, glm::dvec3 place);
  /// Call after the last add(). @return number of vertices at the position of an earlier one.
  uint64_t find();

  /// Returns the first vertex at each vertex's position; query vertices in ascending order.
  class Cursor {
   public:
    explicit Cursor(const SamePlaces& places);
    uint32_t firstAt(uint32_t vertex);

   private:
    SpoolCursor cursor_;
    uint32_t vertex_ = 0, first_ = 0;  ///< the next duplicate and its first vertex
    bool is_at_end_ = false;
    void advance();
  };

 private:
  struct Pair {
    uint32_t vertex, first;
  };
  struct Placed {
    glm::dvec3 place;
    uint32_t vertex;
  };

  const TemporaryFolder& folder_;
  const uint64_t memory_bytes_;
  std::optional<RecordSorter> by_place_;
  std::optional<Spool> pairs_;  ///< sorted by vertex
};

}  // namespace lode::ingest
