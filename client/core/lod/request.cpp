#include "client/core/lod/request.h"

#include <algorithm>
#include <tuple>

namespace lode::core {

std::vector<Request> mergeRequests(std::span<const std::vector<Request>> requests) {
  if (requests.size() == 1) return requests.front();
  std::vector<Request> merged;
  for (const std::vector<Request>& of_view : requests)
    merged.insert(merged.end(), of_view.begin(), of_view.end());
  std::sort(merged.begin(), merged.end(), [](const Request& a, const Request& b) {
    return std::tie(a.use, a.request_class, b.priority_px, a.is_stand_in) <
           std::tie(b.use, b.request_class, a.priority_px, b.is_stand_in);
  });
  const auto is_same = [](const Request& a, const Request& b) { return a.use == b.use; };
  merged.erase(std::unique(merged.begin(), merged.end(), is_same), merged.end());
  std::sort(merged.begin(), merged.end(), [](const Request& a, const Request& b) {
    return std::tie(a.request_class, b.priority_px, a.use) < std::tie(b.request_class, a.priority_px, b.use);
  });
  return merged;
}

}  // namespace lode::core
