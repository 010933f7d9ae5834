#include "client/render/residency/tile_cells.h"

#include <algorithm>
#include <iterator>

#include "client/core/textures/texture_wants.h"

namespace lode::render {

std::optional<TileCell> TileCells::allocate(glm::uvec2 size) {
  static_assert(edgeOf(kOrders - 1) == core::kLeastTileCellPx);
  uint32_t wanted = kOrders - 1;
  while (wanted > 0 && edgeOf(wanted) < std::max(size.x, size.y)) --wanted;
  uint32_t order = wanted;
  while (order > 0 && free_[order].empty()) --order;
  if (free_[order].empty()) {
    if (layers_ >= most_layers_) return std::nullopt;
    free_[0].insert({layers_++, 0, 0});
  }
  const auto [layer, y, x] = *free_[order].begin();
  free_[order].erase(free_[order].begin());
  while (order < wanted) {
    const uint32_t edge = edgeOf(++order);
    free_[order].insert({{layer, y, x + edge}, {layer, y + edge, x}, {layer, y + edge, x + edge}});
  }
  return TileCell{layer, {x, y}, edgeOf(wanted)};
}

void TileCells::release(const TileCell& cell) {
  uint32_t order = 0;
  while (edgeOf(order) > cell.edge) ++order;
  glm::uvec2 corner = cell.corner;
  for (;; --order) {
    std::set<Place>& free = free_[order];
    free.insert({cell.layer, corner.y, corner.x});
    if (order == 0) return;
    const uint32_t edge = edgeOf(order);
    corner = corner / (2 * edge) * (2 * edge);
    const Place quarters[] = {{cell.layer, corner.y, corner.x},
                              {cell.layer, corner.y, corner.x + edge},
                              {cell.layer, corner.y + edge, corner.x},
                              {cell.layer, corner.y + edge, corner.x + edge}};
    if (!std::all_of(std::begin(quarters), std::end(quarters),
                     [&](const Place& q) { return free.contains(q); }))
      return;
    for (const Place& quarter : quarters) free.erase(quarter);
  }
}

}  // namespace lode::render
