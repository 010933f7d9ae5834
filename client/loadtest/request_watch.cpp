#include "client/loadtest/request_watch.h"

#include <utility>

#include "common/codec/blob.h"

namespace lode::app {

void RequestClock::sent(std::span<const std::byte> frames, core::TimePoint now, Requests& lost) {
  forEachFrame(frames, [&](proto::FrameType type, std::span<const std::byte> body) {
    if (type != proto::FrameType::kRequests) return;
    for (const proto::RequestChange& change : proto::decode<proto::Requests>(body).changes) {
      if (change.action == proto::RequestAction::kAdd) {
        const auto before = lost.extract(change.blob);
        open_[change.blob] = {change.request, change.request_class, before ? before.mapped().sent : now};
        blob_of_[change.request] = change.blob;
      } else if (change.action == proto::RequestAction::kCancel) {
        if (const auto found = blob_of_.find(change.request); found != blob_of_.end())
          open_.erase(found->second);
        blob_of_.erase(change.request);
      }
    }
  });
}

std::optional<RequestClock::Request> RequestClock::arrived(uint32_t blob) {
  const auto found = open_.find(blob);
  if (found == open_.end()) return {};
  const Request request = found->second;
  blob_of_.erase(request.number);
  open_.erase(found);
  return request;
}

RequestClock::Requests addLost(RequestClock::Requests& lost, RequestClock::Requests more) {
  while (lost.size() < kMaxLostRequests && !more.empty()) lost.insert(more.extract(more.begin()));
  return more;
}

void OverheardRequests::sent(std::span<const std::byte> frames, double now) {
  forEachFrame(frames, [&](proto::FrameType type, std::span<const std::byte> body) {
    if (type != proto::FrameType::kRequests) return;
    for (const proto::RequestChange& change : proto::decode<proto::Requests>(body).changes) note(change, now);
  });
}

void OverheardRequests::note(const proto::RequestChange& change, double now) {
  if (change.action == proto::RequestAction::kAdd) requests_[change.request] = {change, now, {}, false};
  if (change.action != proto::RequestAction::kCancel) return;
  const auto found = requests_.find(change.request);
  if (found == requests_.end() || std::exchange(found->second.is_cancelled, true)) return;
  cancelled_bytes_ += found->second.bytes.size();
  limitCancelledBytes(change.request);
}

void OverheardRequests::forget(uint32_t number) {
  const auto ended = requests_.extract(number);
  if (ended && ended.mapped().is_cancelled) cancelled_bytes_ -= ended.mapped().bytes.size();
}

void OverheardRequests::limitCancelledBytes(uint32_t number) {
  if (cancelled_bytes_ > core::kMaxCancelledBytes) forget(number);
}

void OverheardRequests::received(std::span<const std::byte> bytes) {
  input_.insert(input_.end(), bytes.begin(), bytes.end());
  const size_t taken = forEachFrame(input_, [&](proto::FrameType type, std::span<const std::byte> body) {
    if (type == proto::FrameType::kBlob) takeChunk(proto::decodeBlobChunk(body));
    if (type == proto::FrameType::kCancelled) forget(proto::decode<proto::Cancelled>(body).request);
    if (type == proto::FrameType::kError) forget(proto::decode<proto::ErrorMessage>(body).request);
  });
  input_.erase(input_.begin(), input_.begin() + static_cast<ptrdiff_t>(taken));
}

void OverheardRequests::takeChunk(const proto::BlobChunk& chunk) {
  const auto found = requests_.find(chunk.header.request);
  if (found == requests_.end()) return;  // the blob was not requested
  Request& request = found->second;
  request.bytes.insert(request.bytes.end(), chunk.bytes.begin(), chunk.bytes.end());
  if (request.is_cancelled) cancelled_bytes_ += chunk.bytes.size();
  if (request.bytes.size() < chunk.header.total_bytes) {
    if (request.is_cancelled) limitCancelledBytes(chunk.header.request);
    return;
  }
  const BlobRef blob{request.asked.blob, chunk.header.total_bytes, digestOf(request.bytes)};
  tell_({blob, {}, request.asked.request_class, request.asked.priority_px}, request.asked_at);
  forget(chunk.header.request);
}

}  // namespace lode::app
