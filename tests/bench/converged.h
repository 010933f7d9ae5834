#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "client/core/cache/decode_job.h"
#include "client/core/lod/view_group.h"
#include "client/core/model.h"
#include "server/store/reader.h"

namespace lode::bench {

/// The converged cut of a client of a store.
class Converged {
 public:
  explicit Converged(const store::Reader& store)
      : store_(store), model_(store.summary(), uint64_t{8} << 30) {}

  std::shared_ptr<const core::Cut> cut(const core::View& view, float threshold_px) {
    group_.setView(view, threshold_px);
    while (true) {
      group_.refine(model_);
      std::vector<core::Request> requests = group_.requests();
      if (const auto first = model_.firstRequest()) requests.push_back(*first);
      if (requests.empty()) return group_.cut();
      for (const core::Request& request : requests) {
        if (!model_.wants(request)) continue;
        model_.take(request.blob, request.use, store_.readBlob(request.blob.number));
        for (auto jobs = model_.takeDecodeJobs(); !jobs.empty(); jobs = model_.takeDecodeJobs())
          for (const core::DecodeJob& job : jobs) model_.finishDecode(runDecodeJob(job));
      }
    }
  }

 private:
  const store::Reader& store_;
  core::Model model_;
  core::ViewGroup group_;
};

inline core::View turned(const core::View& view, double angle_rad) {
  core::View next = view;
  next.forward = glm::normalize(view.forward + std::tan(angle_rad) * glm::cross(view.forward, view.up));
  return next;
}

}  // namespace lode::bench
