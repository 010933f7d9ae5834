#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace lode::serve {

/// The memory of this process that is no file's and is resident; 0 where the system does not say.
uint64_t anonymousResidentBytes();
/// What this process has of malloc and has not freed, whatever malloc keeps beside it.
uint64_t allocatedBytes();

/// Tells when malloc shall give freed memory to the system: by itself it keeps nearly all that a flood of
/// requests or answers made it take.
class TrimWatch {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Less is not worth it, and stays resident.
  static constexpr uint64_t kLeastBytes = 4u << 20;
  static constexpr std::chrono::seconds kEvery{1};

  /// When it is worth looking again.
  bool due(Time now) const noexcept { return now >= next_; }
  /// @param resident_bytes  as above. @param used_bytes  what connections hold of it.
  /// @return whether much is resident that nobody uses, and that has come, or may have become free to give,
  ///         since it was time before.
  bool isTime(uint64_t resident_bytes, uint64_t used_bytes, Time now) noexcept {
    next_ = now + kEvery;
    const uint64_t unused_bytes = resident_bytes - std::min(resident_bytes, used_bytes);
    least_bytes_ = std::min(least_bytes_, unused_bytes);
    stayed_bytes_ = trimmed_ ? unused_bytes : std::min(stayed_bytes_, unused_bytes);
    const bool new_chance =
        unused_bytes - stayed_bytes_ >= kLeastBytes || used_bytes < used_before_bytes_ / 2;
    trimmed_ = unused_bytes - least_bytes_ >= kLeastBytes && new_chance;
    if (trimmed_) used_before_bytes_ = used_bytes;
    return trimmed_;
  }

 private:
  uint64_t least_bytes_ = UINT64_MAX;   ///< that nobody used, ever: the program itself
  uint64_t stayed_bytes_ = UINT64_MAX;  ///< of what nobody used, when it was time before
  uint64_t used_before_bytes_ = 0;      ///< then
  bool trimmed_ = false;                ///< it was time the last time
  Time next_{};
};

}  // namespace lode::serve
