#include "client/render/draw_list.h"

#include <algorithm>

namespace lode::render {

void DrawList::clear(size_t pages) {
  by_page.resize(pages);
  for (auto& page : by_page) page.clear();
}

void DrawList::add(const SeenCluster& cluster) {
  const DrawItem& item = *cluster.part.item;
  std::vector<DrawCommand>& page = by_page[item.page];
  const uint32_t index = item.first_index + 3 * cluster.firstTriangle(), count = 3 * cluster.triangles();
  if (!page.empty() && page.back().base_instance == cluster.part.state &&
      page.back().first_index + page.back().count == index)
    page.back().count += count;
  else
    page.push_back({count, 1, index, static_cast<int32_t>(item.base_vertex), cluster.part.state});
}

bool DrawList::empty() const noexcept {
  return std::ranges::all_of(by_page, &std::vector<DrawCommand>::empty);
}

}  // namespace lode::render
