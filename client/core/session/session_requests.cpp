#include <algorithm>
#include <unordered_set>
#include <utility>
#include <vector>

#include "client/core/session/session.h"
#include "common/release_storage.h"
#include "proto/limits.h"

/// The members of Session that manage requests.
namespace lode::core {
namespace {

bool differsMuch(float a, float b) { return a > b * kReprioritiseFactor || b > a * kReprioritiseFactor; }

}  // namespace

void Session::countRequest(const OpenRequest& request, bool is_open) {
  const uint64_t one = is_open ? 1 : -uint64_t{1};
  request_counts_[request.request_class] += one;
  if (request.incoming.use.kind == BlobKind::kTile) request_counts_.tiles += one;
}

Session::Incoming Session::endRequest(uint32_t request) {
  OpenRequest ended = std::move(requests_.extract(request).mapped());
  countRequest(ended, false);
  if (ended.cancelling)
    cancelled_bytes_ -= ended.incoming.bytes.size();
  else
    requested_bytes_ -= ended.incoming.blob.bytes;
  request_of_blob_.erase(ended.incoming.blob.number);
  return std::move(ended.incoming);
}

void Session::cancel(OpenRequest& request) {
  request.cancelling = true;
  requested_bytes_ -= request.incoming.blob.bytes;
  cancelled_bytes_ += request.incoming.bytes.size();
  limitCancelledBytes(request);
}

/// Drops the bytes of a cancelled request if kMaxCancelledBytes is exceeded. Otherwise a server that never
/// acknowledges cancellations could fill the client's memory.
void Session::limitCancelledBytes(OpenRequest& request) {
  if (cancelled_bytes_ <= kMaxCancelledBytes) return;
  cancelled_bytes_ -= request.incoming.bytes.size();
  releaseStorage(request.incoming.bytes);
  request.incoming.is_dropped = true;
}

bool Session::setRequests(std::span<const Request> wanted) {
  if (state_ != State::kOpen) return true;
  if (outgoing_.size() > proto::kMaxQueuedAnswerBytes) return false;
  std::unordered_set<uint32_t> accepted;
  std::vector<proto::RequestChange> changes;
  std::vector<const Request*> additions;
  uint64_t accepted_bytes = 0;
  for (const Request& wanting : wanted) {
    const BlobRef& blob = wanting.blob;
    if (accepted.size() >= max_open_requests_) break;
    if (!accepted.empty() && accepted_bytes + blob.bytes > options_.max_requested_bytes) break;
    if (unasked_ && unasked_->blob.number == blob.number) continue;
    if (!accepted.insert(blob.number).second) continue;
    accepted_bytes += blob.bytes;
    const auto open = request_of_blob_.find(blob.number);
    if (open == request_of_blob_.end()) {
      if (requests_.size() + additions.size() < kMaxUnendedRequests) additions.push_back(&wanting);
      continue;
    }
    OpenRequest& request = requests_.at(open->second);
    const bool moved = request.request_class != wanting.request_class ||
                       differsMuch(request.priority_px, wanting.priority_px);
    if (request.cancelling || !moved) continue;
    countRequest(request, false);
    request.request_class = wanting.request_class;
    countRequest(request, true);
    request.priority_px = wanting.priority_px;
    changes.push_back({proto::RequestAction::kReprioritise, request.request_class, open->second, blob.number,
                       request.priority_px});
  }
  for (auto& [number, request] : requests_) {
    if (request.cancelling || accepted.contains(request.incoming.blob.number)) continue;
    cancel(request);
    changes.push_back(
        {proto::RequestAction::kCancel, request.request_class, number, request.incoming.blob.number, 0});
  }
  for (const Request* wanting : additions) {
    const BlobRef& blob = wanting->blob;
    const uint32_t number = next_request_++;
    const OpenRequest request{{blob, wanting->use}, wanting->request_class, wanting->priority_px, false};
    countRequest(request, true);
    requests_.emplace(number, request);
    request_of_blob_.emplace(blob.number, number);
    requested_bytes_ += blob.bytes;
    changes.push_back(
        {proto::RequestAction::kAdd, wanting->request_class, number, blob.number, wanting->priority_px});
  }
  sendChanges(changes);
  return true;
}

void Session::sendChanges(std::span<const proto::RequestChange> changes) {
  while (!changes.empty()) {
    const auto some = changes.first(std::min<size_t>(changes.size(), proto::kMaxRequestsPerFrame));
    send(proto::encode(proto::Requests{handle_, {some.begin(), some.end()}}, next_call_++));
    changes = changes.subspan(some.size());
  }
}

}  // namespace lode::core
