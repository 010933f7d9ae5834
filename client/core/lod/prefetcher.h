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

constexpr std::chrono::milliseconds kPrefetchAhead{1000};    ///< the place where a camera will be then
constexpr std::chrono::milliseconds kPrefetchInterval{100};  ///< between two looks ahead
constexpr uint64_t kMaxPrefetchBytes = 256u << 10;           ///< asked for at one time
constexpr uint64_t kPrefetchMemoryShare = 4;  ///< one in so many bytes of the meshes' stays for what is seen

struct PrefetchCounts {
  uint64_t requested = 0;     ///< blobs asked for
  uint64_t used = 0;          ///< of these, that a view has needed since
  uint64_t unused = 0;        ///< that have come, and no view has needed yet
  uint64_t unused_bytes = 0;  ///< of them
};

/// Asks for what a moving camera will see next, after all that it sees now. Not thread safe.
class Prefetcher {
 public:
  /// How many views there are, one for each place where the model stands. Other places than before: nothing
  /// is known of how they move.
  void expectViews(size_t count);
  /// The camera as a place sees it, each time that it is looked at.
  void see(size_t view_number, const View& view, TimePoint now) { motions_[view_number].see(view, now); }

  /// Looks ahead, where that is due. @return whether there are other requests than before.
  bool lookAhead(const Model& model, const RefineOptions& options, TimePoint now);
  /// What the camera will need and lacks, best first; of the last look.
  const std::vector<Request>& requests() const noexcept { return requests_; }

  /// Of a request that was sent.
  void asked(const Request& request);
  /// Of any blob.
  void arrived(const BlobRef& blob, const BlobUse& use);
  /// What the views show, go through, and ask for.
  /// @param view_cuts  may be null.
  void needed(const ViewCuts* view_cuts, std::span<const NodeKey> pages, std::span<const Request> requests);
  const PrefetchCounts& counts() const noexcept { return counts_; }

  /// Another build has taken the model's place.
  void forgetModel();

 private:
  struct Open {
    uint64_t bytes = 0;         // 0: it has not come
    bool is_requested = false;  // still
  };
  std::vector<Request> wantedAhead(const Model& model, const RefineOptions& options, TimePoint now) const;
  void use(const BlobUse& use);

  std::vector<CameraMotion> motions_;  // by view
  std::optional<TimePoint> looked_at_;
  std::vector<Request> requests_;
  std::map<BlobUse, Open> open_;  // asked for, and not needed so far
  PrefetchCounts counts_;
};

}  // namespace lode::core
