#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>

#include "client/core/view/time_point.h"

namespace lode::core {

/// Pause before refused requests are repeated for the first time. Each later pause is 1.5 times as long as
/// the previous one.
constexpr std::chrono::seconds kFirstRepeat{1};
constexpr std::chrono::seconds kLastRepeat{30};  ///< upper limit of all pauses
/// Largest number of postponed blobs. A full list is cleared, and its blobs may be requested at once.
constexpr size_t kMaxPostponedBlobs = 65'536;

/// Keeps track of the blobs that the server refuses for now, for example because its storage fails. One pause
/// applies to all of them; after it, they may be requested again. Not thread safe.
class PostponedBlobs {
 public:
  /// @param why  reason for the refusal, worded for users.
  void add(uint32_t blob, const std::string& why, TimePoint now);
  /// Returns true if the blob must not be requested yet.
  bool contains(uint32_t blob) const { return waiting_.contains(blob); }
  /// Notes that the blob has arrived.
  void arrived(uint32_t blob);
  /// Allows the blobs to be requested again if their pause is over. @return true if there are blobs to
  /// request again.
  bool release(TimePoint now);
  /// Returns the reason for the first refusal. Empty once all refused blobs have arrived, or once a whole
  /// pause has passed without another refusal.
  const std::string& why() const noexcept { return why_; }

 private:
  void endIfEmpty();

  std::set<uint32_t> waiting_;   ///< blobs whose pause is not over
  std::set<uint32_t> released_;  ///< blobs that may be requested again and have not been answered
  std::chrono::milliseconds pause_{kFirstRepeat};
  TimePoint due_{};  ///< end of the pause
  std::string why_;
};

}  // namespace lode::core
