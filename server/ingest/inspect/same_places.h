#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/disk/temporary_folder.h"

namespace lode::ingest {

/// Finds vertices that have exactly the same position as an earlier vertex, by sorting in bounded memory. Not
/// thread safe. All functions throw Error kIo.
class SamePlaces {
 public:
  SamePlaces(const TemporaryFolder& folder, uint64_t memory_bytes);

  /// Adds a vertex and its position. @pre calls are in ascending order of `vertex`.
  void add(uint32_t vertex, glm::dvec3 place);
  /// Finds the duplicates; call it after the last add(). @return number of vertices at the position of an
  /// earlier vertex.
  uint64_t find();

  /// Looks up the first vertex at the position of a vertex. Call firstAt() with ascending vertex indices.
  class Cursor {
   public:
    explicit Cursor(const SamePlaces& places);
    uint32_t firstAt(uint32_t vertex);

   private:
    SpoolCursor cursor_;
    uint32_t vertex_ = 0, first_ = 0;  ///< next duplicate, and the first vertex at its position
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
  /// Pairs of a duplicate and the first vertex at its position, sorted by duplicate.
  std::optional<Spool> pairs_;
};

}  // namespace lode::ingest
