#include "server/ingest/simplify/edge_surroundings.h"

#include <cstring>

namespace lode::ingest {

// Gathers the triangles at an end. Uses no branch, because the processor cannot predict which triangles
// contain the edge.
void EdgeSurroundings::gatherEnd(uint32_t end, uint32_t other, size_t& sides, size_t& apexes) {
  for (const uint32_t corner : mesh_.around(end)) {
    const Side side{mesh_.at(CollapseMesh::next(corner)), mesh_.at(CollapseMesh::previous(corner))};
    const bool of_edge = (side.a == other) | (side.b == other);
    sides_[sides] = side;
    apexes_[apexes] = side.a ^ side.b ^ other;
    sides += !of_edge;
    apexes += of_edge;
  }
}

FourVectors EdgeSurroundings::four(uint32_t a, uint32_t b, uint32_t c, uint32_t d) const noexcept {
  using Whole = int32_t __attribute__((vector_size(16)));
  const auto at = [this](uint32_t position) {
    Whole place;
    std::memcpy(&place, &mesh_.points[position], sizeof place);
    return __builtin_convertvector(place, Four);
  };
  return {at(a), at(b), at(c), at(d)};
}

void EdgeSurroundings::gather(uint32_t u, uint32_t v) {
  u_ = u;
  v_ = v;
  const size_t most = mesh_.positions[u].count + mesh_.positions[v].count;
  if (sides_.size() < most + 4) {
    sides_.resize(most + 4);
    apexes_.resize(sides_.size());
  }
  size_t sides = 0, apexes = 0;
  gatherEnd(u, v, sides, apexes);
  of_u_ = sides;
  of_both_ = apexes;
  gatherEnd(v, u, sides, apexes);
  of_v_ = sides - of_u_;
  if (sides == 0) return;
  if (places_.size() < (sides + 3) / 4) places_.resize((sides + 3) / 4);
  for (size_t i = sides; i % 4 != 0; ++i) sides_[i] = sides_[sides - 1];
  for (size_t i = 0; i < sides; i += 4) {
    const Side* const s = &sides_[i];
    places_[i / 4] = {four(s[0].a, s[1].a, s[2].a, s[3].a), four(s[0].b, s[1].b, s[2].b, s[3].b)};
  }
}

}  // namespace lode::ingest
