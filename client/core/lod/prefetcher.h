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

constexpr std::chrono::milliseconds kPrefetchAhead{1000};    ///< time between now and the predicted view
constexpr std::chrono::milliseconds kPrefetchInterval{100};  ///< shortest time between two predictions
constexpr uint64_t kMaxPrefetchBytes = 256u << 10;           ///< largest total size of the prefetch requests
/// Largest number of prefetched blobs that are tracked until a view needs them. Any further blobs are not
/// counted.
constexpr size_t kMaxUnusedPrefetches = 65'536;
/// Prefetching leaves 1/4 of the mesh budget free for visible meshes.
constexpr uint64_t kPrefetchMemoryShare = 4;

struct PrefetchCounts {
  uint64_t requested = 0;     ///< number of prefetch requests sent, answered or not
  uint64_t used = 0;          ///< number of prefetched blobs that a view has needed since then
  uint64_t unused = 0;        ///< number of prefetched blobs received, but not needed by a view yet
  uint64_t unused_bytes = 0;  ///< size of the unused blobs

  PrefetchCounts& operator+=(const PrefetchCounts& other) noexcept {
    requested += other.requested;
    used += other.used;
    unused += other.unused;
    unused_bytes += other.unused_bytes;
    return *this;
  }
  bool operator==(const PrefetchCounts&) const = default;
};

/// Predicts the views of moving cameras, and requests the blobs that the predicted views need. These requests
/// come after all requests of the current views. Not thread safe.
class Prefetcher {
 public:
  /// Sets the number of views, one per instance of the model. A different number discards the recorded
  /// motion.
  void setViewCount(size_t count);
  /// Records the current view of an instance. @param view_number  number less than the view count.
  void record(size_t view_number, const View& view, TimePoint now) {
    motions_[view_number].record(view, now);
  }

  /// Predicts the views and renews the requests, at most once per kPrefetchInterval.
  /// @return true if the requests may have changed.
  bool lookAhead(const Model& model, const RefineOptions& options, TimePoint now);
  /// Returns requests for the missing blobs of the predicted views, best first.
  const std::vector<Request>& requests() const noexcept { return requests_; }

  /// Notes that a prefetch request was sent.
  void asked(const Request& request);
  /// Notes that a blob, prefetched or not, was received.
  void arrived(const BlobRef& blob, const BlobUse& use);
  /// Counts a prefetched blob as used if a view shows its mesh, uses its page or requests it.
  /// @param view_cuts  cuts whose visible parts count as shown; may be null.
  /// @param pages      owners of the used pages.
  void needed(const ViewCuts* view_cuts, std::span<const NodeKey> pages, std::span<const Request> requests);
  const PrefetchCounts& counts() const noexcept { return counts_; }

  /// Discards all requests, because another build has replaced the model.
  void forgetModel();

 private:
  struct Open {
    uint64_t bytes = 0;         // size of the blob; 0 until received
    bool is_requested = false;  // true while the blob is among the requests
  };
  std::vector<Request> wantedAhead(const Model& model, const RefineOptions& options, TimePoint now) const;
  void use(const BlobUse& use);

  std::vector<CameraMotion> motions_;  // indexed by view
  std::optional<TimePoint> predicted_at_;
  std::vector<Request> requests_;
  std::map<BlobUse, Open> open_;  // prefetched blobs that no view has needed yet
  PrefetchCounts counts_;
};

}  // namespace lode::core
