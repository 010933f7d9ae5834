#include "server/ingest/inspect/same_places.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <span>
#include <vector>

#include "server/ingest/mesh/number_table.h"

namespace lode::ingest {
namespace {

/// Hashes a position. -0 and 0 have the same hash.
uint64_t hashOf(glm::dvec3 place) noexcept {
  uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis)
    hash = NumberTable::hash(hash * 31 + std::bit_cast<uint64_t>(place[axis] + 0.0));
  return hash;
}

}  // namespace

SamePlaces::SamePlaces(const TemporaryFolder& folder, uint64_t memory_bytes)
    : folder_(folder), memory_bytes_(memory_bytes) {
  by_place_.emplace(sizeof(Placed), memory_bytes, folder.file("by-place"));
}

void SamePlaces::add(uint32_t vertex, glm::dvec3 place) {
  Placed placed;
  std::memset(static_cast<void*>(&placed), 0, sizeof(placed));
  placed.place = place;
  placed.vertex = vertex;
  by_place_->push(hashOf(place), std::as_bytes(std::span(&placed, 1)));
}

uint64_t SamePlaces::find() {
  by_place_->finish();
  RecordSorter by_vertex(sizeof(uint32_t), memory_bytes_ / 4, folder_.file("by-vertex"));
  std::vector<Placed> of_one_hash;  // first vertex at each place with the current hash; usually one
  uint64_t hash = 0;
  while (const auto record = by_place_->next()) {
    Placed placed;
    std::memcpy(static_cast<void*>(&placed), record->bytes.data(), sizeof(placed));
    if (record->key != hash) of_one_hash.clear();
    hash = record->key;
    const auto first = std::ranges::find(of_one_hash, placed.place, &Placed::place);
    if (first == of_one_hash.end()) {
      of_one_hash.push_back(placed);
    } else {
      by_vertex.push(placed.vertex, std::as_bytes(std::span(&first->vertex, 1)));
    }
  }
  by_place_.reset();
  by_vertex.finish();
  pairs_.emplace(folder_.file("same-places"));
  while (const auto record = by_vertex.next()) {
    Pair pair{static_cast<uint32_t>(record->key), 0};
    std::memcpy(&pair.first, record->bytes.data(), sizeof(pair.first));
    pairs_->append(std::span<const Pair>(&pair, 1));
  }
  pairs_->flush();
  return pairs_->size() / sizeof(Pair);
}

SamePlaces::Cursor::Cursor(const SamePlaces& places) : cursor_(*places.pairs_, 0, places.pairs_->size()) {
  advance();
}

void SamePlaces::Cursor::advance() {
  is_at_end_ = cursor_.atEnd();
  if (is_at_end_) return;
  Pair next;
  cursor_.take(std::span<Pair>(&next, 1));
  vertex_ = next.vertex;
  first_ = next.first;
}

uint32_t SamePlaces::Cursor::firstAt(uint32_t vertex) {
  while (!is_at_end_ && vertex_ < vertex) advance();
  return is_at_end_ || vertex_ != vertex ? vertex : first_;
}

}  // namespace lode::ingest
