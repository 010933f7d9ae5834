#include "client/loadtest/request_clock.h"

#include "client/loadtest/whole_frames.h"

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

}  // namespace lode::app
