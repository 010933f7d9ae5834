#include "client/core/lod/prefetcher.h"

#include "client/core/lod/refiner.h"
#include "client/core/lod/request.h"

namespace lode::core {

void Prefetcher::setViewCount(size_t count) {
  if (motions_.size() != count) motions_.assign(count, {});
}

bool Prefetcher::lookAhead(const Model& model, const RefineOptions& options, TimePoint now) {
  if (predicted_at_ && now - *predicted_at_ < kPrefetchInterval) return false;
  predicted_at_ = now;
  const bool had_requests = !requests_.empty();
  requests_.clear();
  for (auto& [use, open] : open_) open.is_requested = false;
  const uint64_t budget_bytes = model.meshes().budgetBytes();
  if (!model.hierarchy().root() ||
      model.meshes().bytes() > budget_bytes - budget_bytes / kPrefetchMemoryShare)
    return had_requests;
  uint64_t bytes = 0;
  for (Request request : wantedAhead(model, options, now)) {
    // Requests are sorted by class, visible first.
    if (request.request_class != proto::RequestClass::kVisible) break;
    if (!model.wants(request)) continue;
    bytes += request.blob.bytes;
    if (bytes > kMaxPrefetchBytes && !requests_.empty()) break;
    request.request_class = proto::RequestClass::kPrefetch;
    requests_.push_back(request);
  }
  return had_requests || !requests_.empty();
}

/// Returns the merged requests of all predicted views, best first.
std::vector<Request> Prefetcher::wantedAhead(const Model& model, const RefineOptions& options,
                                             TimePoint now) const {
  std::vector<std::vector<Request>> wanted;
  for (const CameraMotion& motion : motions_)
    if (const std::optional<View> ahead = motion.predict(now, kPrefetchAhead))
      wanted.push_back(refine({model.hierarchy(), model.meshes(), model.summary().lattice.step,
                               model.summary().attributes},
                              *ahead, options)
                           .wanted);
  return mergeRequests(wanted);
}

void Prefetcher::asked(const Request& request) {
  if (open_.size() >= kMaxUnusedPrefetches && !open_.contains(request.use)) return;
  const auto [open, is_new] = open_.try_emplace(request.use);
  if (is_new) ++counts_.requested;
  open->second.is_requested = true;
}

void Prefetcher::arrived(const BlobRef& blob, const BlobUse& use) {
  std::erase_if(requests_, [&](const Request& request) { return request.blob.number == blob.number; });
  const auto open = open_.find(use);
  if (open == open_.end() || open->second.bytes != 0) return;
  open->second.bytes = blob.bytes;
  ++counts_.unused;
  counts_.unused_bytes += blob.bytes;
}

void Prefetcher::needed(const ViewCuts* view_cuts, std::span<const NodeKey> pages,
                        std::span<const Request> requests) {
  if (open_.empty()) return;
  if (view_cuts != nullptr)
    for (const auto& cut : view_cuts->cuts)
      for (const CutPart& part : cut->parts)
        if (part.visible) use({BlobKind::kMesh, {part.node, part.lod}});
  for (const NodeKey page : pages) use({BlobKind::kPage, {page, 0}});
  for (const Request& request : requests)
    if (request.request_class == proto::RequestClass::kVisible) use(request.use);
}

void Prefetcher::use(const BlobUse& use) {
  const auto open = open_.find(use);
  if (open == open_.end()) return;
  const Open ended = open->second;
  open_.erase(open);
  if (ended.bytes != 0) {
    --counts_.unused;
    counts_.unused_bytes -= ended.bytes;
  }
  if (ended.bytes != 0 || ended.is_requested) ++counts_.used;
}

void Prefetcher::forgetModel() {
  requests_.clear();
  open_.clear();
  predicted_at_.reset();
}

}  // namespace lode::core
