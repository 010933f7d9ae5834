#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>

#include "client/core/view/time_point.h"

namespace lode::core {

/// Pause before the first repetition of refused requests. Each further pause is 1.5 times as long as the
/// pause before.
constexpr std::chrono::seconds kFirstRepeat{1};
constexpr std::chrono::seconds kLastRepeat{30};  ///< longest pause before a repetition
/// Largest number of postponed blobs. Above this number, all blobs leave the list and may be requested at
/// once.
constexpr size_t kMaxPostponedBlobs = 65'536;

/// Blobs that the server refuses for now, for example because its storage fails. After a pause, all
/// refused blobs may be requested again at the same time. Not thread safe.
class PostponedBlobs {
 public:
  /// @param why  reason as a text for users.
  void add(uint32_t blob, const std::string& why, TimePoint now);
  /// Returns true if the blob must not be requested yet.
  bool contains(uint32_t blob) const { return waiting_.contains(blob); }
  /// Notes that the blob has arrived.
  void arrived(uint32_t blob);
  /// Releases the blobs when their pause is over. @return true if there are blobs to request again.
  bool release(TimePoint now);
  /// Returns the reason why the first blob was refused. The reason becomes empty once all refused blobs have
  /// arrived, or after a pause in which no blob was refused again.
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
