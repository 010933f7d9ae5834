#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "client/core/lod/camera_motion.h"
#include "client/core/lod/cut.h"
#include "client/core/lod/refine_options.h"
#include "client/core/lod/request.h"
#include "client/core/model.h"
#include "client/core/view/time_point.h"

namespace lode::core {

constexpr std::chrono::milliseconds kPrefetchAhead{1000};    ///< how far ahead the camera is predicted
constexpr std::chrono::milliseconds kPrefetchInterval{100};  ///< between two predictions
constexpr uint64_t kMaxPrefetchBytes = 256u << 10;           ///< requested at one time
constexpr uint64_t kPrefetchMemoryShare = 4;  ///< 1/4 of the mesh budget stays free for visible meshes

struct PrefetchCounts {
  uint64_t requested = 0;     ///< prefetched blobs, received or not
  uint64_t used = 0;          ///< prefetched blobs that a view has needed since
  uint64_t unused = 0;        ///< received, but not needed by a view yet
  uint64_t unused_bytes = 0;  ///< size of the unused blobs
};

/// Requests what moving cameras will see next, after everything that they see now. Not thread safe.
class Prefetcher {
 public:
  /// Sets the number of views, one per instance of the model. A new number discards the recorded motion.
  void setViewCount(size_t count);
  /// Records the current view of an instance. @param view_number  below the view count.
  void record(size_t view_number, const View& view, TimePoint now) {
    motions_[view_number].record(view, now);
  }

  /// Predicts the views at most every kPrefetchInterval and renews the requests.
  /// @return true if the requests may have changed.
  bool lookAhead(const Model& model, const RefineOptions& options, TimePoint now);
  /// Missing blobs of the predicted views, best first.
  const std::vector<Request>& requests() const noexcept { return requests_; }

  /// Notes that a prefetch request was sent.
  void asked(const Request& request);
  /// Notes that a blob, prefetched or not, was received.
  void arrived(const BlobRef& blob, const BlobUse& use);
  /// Notes what the views show, pass through and request, and counts prefetched blobs among it as used.
  /// @param view_cuts  may be null.
  void needed(const ViewCuts* view_cuts, std::span<const NodeKey> pages, std::span<const Request> requests);
  const PrefetchCounts& counts() const noexcept { return counts_; }

  /// Discards all requests: another build has replaced the model.
  void forgetModel();

 private:
  struct Open {
    uint64_t bytes = 0;         // 0: not received
    bool is_requested = false;  // still among the requests
  };
  std::vector<Request> wantedAhead(const Model& model, const RefineOptions& options, TimePoint now) const;
  void use(const BlobUse& use);

  std::vector<CameraMotion> motions_;  // by view
  std::optional<TimePoint> predicted_at_;
  std::vector<Request> requests_;
  std::map<BlobUse, Open> open_;  // requested, and not needed by a view yet
  PrefetchCounts counts_;
};

}  // namespace lode::core
