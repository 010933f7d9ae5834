#include "server/store/page_split.h"

#include <algorithm>

namespace lode::store {

std::vector<PagePlan> splitIntoPages(std::vector<Node> nodes) {
  std::vector<PagePlan> pages;
  pages.push_back({kRootKey, {}});
  for (const Node& node : nodes)
    if (ownsPage(node)) pages.push_back({node.key, {}});
  for (Node& node : nodes) {
    const NodeKey owner = pageOwner(node.key);
    const auto page = std::lower_bound(pages.begin(), pages.end(), owner,
                                       [](const PagePlan& plan, NodeKey key) { return plan.owner < key; });
    page->page.nodes.push_back(std::move(node));
  }
  return pages;
}

}  // namespace lode::store
