#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/disk/temporary_folder.h"

namespace lode::ingest {

/// Finds vertices at exactly the place of an earlier one, by sorts in a bounded memory. For one thread. All
/// functions throw Error kIo.
class SamePlaces {
 public:
  SamePlaces(const TemporaryFolder& folder, uint64_t memory_bytes);

  /// Vertices are added in the order of their numbers.
  void add(uint32_t vertex, glm::dvec3 place);
  /// When all are added. @return how many are at the place of an earlier one.
  uint64_t find();

  /// Tells the first vertex at the place of each, for vertices in rising order.
  class Cursor {
   public:
    explicit Cursor(const SamePlaces& places);
    uint32_t firstAt(uint32_t vertex);

   private:
    SpoolCursor cursor_;
    uint32_t vertex_ = 0, first_ = 0;  ///< the next that is at the place of an earlier one
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
  std::optional<Spool> pairs_;  ///< by vertex
};

}  // namespace lode::ingest
