#include "client/loadtest/recorded_requests.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/error.h"

namespace lode::app {

void RecordedRequests::requireRoom(size_t count) const {
  if (count < most_) return;
  throw Error(ErrorCode::kLimit,
              "the path requests more than " + std::to_string(most_) + " blobs: record a shorter path");
}

void RecordedRequests::add(const core::Request& request, double t_s) {
  requireRoom(requests_.size());
  requests_.push_back({t_s, request, {}});
}

void RecordedRequests::addJob(core::DecodeJob job) {
  const Digest name = digestOf(job.bytes);
  if (jobs_.contains(name)) return;
  requireRoom(jobs_.size());
  job.bytes = {};
  jobs_.emplace(name, std::move(job));
}

std::vector<TracedRequest> RecordedRequests::take() {
  for (TracedRequest& traced : requests_)
    if (const auto job = jobs_.find(traced.request.blob.digest); job != jobs_.end())
      traced.decode = job->second;
  std::ranges::stable_sort(requests_, {}, &TracedRequest::t_s);
  return std::exchange(requests_, {});
}

}  // namespace lode::app
