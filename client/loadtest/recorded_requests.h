#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "client/core/cache/decode_job.h"
#include "client/core/lod/request.h"
#include "client/loadtest/request_trace.h"
#include "common/codec/blob.h"

namespace lode::app {

/// The requests of a trace that is being recorded, and the jobs that decode their blobs. Not thread safe.
class RecordedRequests {
 public:
  /// @param most  largest number of requests, and of different blobs to decode.
  explicit RecordedRequests(size_t most = kMaxTracedRequests) : most_(most) {}

  /// Adds a request. @throws Error kLimit if there are as many requests as the limit allows.
  void add(const core::Request& request, double t_s);
  /// Notes how a blob is decoded. Keeps one job per blob, without the bytes. @throws Error kLimit as add().
  void addJob(core::DecodeJob job);
  /// Returns the requests in order of time, each with the job that decodes its blob.
  std::vector<TracedRequest> take();

 private:
  void requireRoom(size_t count) const;

  size_t most_;
  std::vector<TracedRequest> requests_;
  std::map<Digest, core::DecodeJob> jobs_;
};

}  // namespace lode::app
