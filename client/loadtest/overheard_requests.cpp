#include "client/loadtest/overheard_requests.h"

#include <utility>

#include "client/loadtest/whole_frames.h"
#include "common/codec/blob.h"

namespace lode::app {
void OverheardRequests::sent(std::span<const std::byte> frames, double now) {
  forEachFrame(frames, [&](proto::FrameType type, std::span<const std::byte> body) {
    if (type != proto::FrameType::kRequests) return;
    for (const proto::RequestChange& change : proto::decode<proto::Requests>(body).changes)
      if (change.action == proto::RequestAction::kAdd) requests_[change.request] = {change, now, {}};
  });
}

void OverheardRequests::received(std::span<const std::byte> bytes) {
  input_.insert(input_.end(), bytes.begin(), bytes.end());
  const size_t taken = forEachFrame(input_, [&](proto::FrameType type, std::span<const std::byte> body) {
    if (type == proto::FrameType::kBlob) takeChunk(proto::decodeBlobChunk(body));
  });
  input_.erase(input_.begin(), input_.begin() + static_cast<ptrdiff_t>(taken));
}

void OverheardRequests::takeChunk(const proto::BlobChunk& chunk) {
  const auto found = requests_.find(chunk.header.request);
  if (found == requests_.end()) return;  // unasked
  Request& request = found->second;
  request.bytes.insert(request.bytes.end(), chunk.bytes.begin(), chunk.bytes.end());
  if (request.bytes.size() < chunk.header.total_bytes) return;
  const BlobRef blob{request.asked.blob, chunk.header.total_bytes, digestOf(request.bytes)};
  tell_({blob, {}, request.asked.request_class, request.asked.priority_px}, request.asked_at);
  requests_.erase(found);
}

}  // namespace lode::app
