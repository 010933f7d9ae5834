#include "client/stream/published_cuts.h"

namespace lode::stream {
namespace {

template <typename T>
void addTo(std::vector<std::shared_ptr<const T>>& published, const std::shared_ptr<const T>& one) {
  if (one && (published.empty() || published.back() != one)) published.push_back(one);
}

template <typename T>
void releaseStorageOf(std::vector<std::shared_ptr<const T>>& published) {
  std::erase_if(published, [](const std::shared_ptr<const T>& one) { return one.use_count() == 1; });
}

}  // namespace

void PublishedCuts::add(const std::shared_ptr<const core::Cut>& cut,
                        const std::shared_ptr<const core::ViewCuts>& view_cuts) {
  addTo(cuts_, cut);
  addTo(view_cuts_, view_cuts);
}

void PublishedCuts::releaseStorage() {
  releaseStorageOf(view_cuts_);  // view cuts come first, because they hold references to cuts
  releaseStorageOf(cuts_);
}

}  // namespace lode::stream
